// A thread's share of the processor.
#pragma once

namespace vernier {

// Lets the calling thread give way to threads of ordinary priority, as an interface's are. Does
// nothing where the system has no such thing for single threads.
void give_way();

}  // namespace vernier
