#include "bindings/bind.h"

#include <nanobind/stl/string.h>

#include "embree/library.h"
#include "embree/recorder.h"
#include "render/passes.h"
#include "render/settings.h"

namespace nb = nanobind;

namespace vernier {
namespace {

nb::str str(std::string_view text) { return nb::str(text.data(), text.size()); }

// Rows as dictionaries: engine_core/tables.py makes dataclasses of them.
nb::list parameter_rows() {
  nb::list rows;
  for (const Parameter& p : parameters()) {
    nb::dict row;
    row["name"] = str(p.name);
    row["group"] = str(p.group);
    row["label"] = str(p.label);
    row["description"] = str(p.description);
    row["unit"] = str(p.unit);
    nb::list items;
    for (const EnumItem& item : p.items) {
      items.append(nb::make_tuple(str(item.identifier), str(item.label), str(item.description)));
    }
    row["items"] = nb::tuple(items);
    switch (p.type) {
      case ParameterType::kEnum:
        row["type"] = "enum";
        row["default"] = str(p.items[static_cast<size_t>(p.initial)].identifier);
        break;
      case ParameterType::kInteger:
        row["type"] = "int";
        row["default"] = static_cast<int>(p.initial);
        break;
      case ParameterType::kReal:
        row["type"] = "float";
        row["default"] = p.initial;
        break;
    }
    row["of_film"] = p.of_film();
    row["minimum"] = p.minimum;
    row["maximum"] = p.maximum;
    row["soft_minimum"] = p.soft_minimum;
    row["soft_maximum"] = p.soft_maximum;
    rows.append(row);
  }
  return rows;
}

nb::list pass_rows() {
  nb::list rows;
  for (const PassInfo& p : kPasses) {
    nb::dict row;
    row["name"] = str(p.name);
    row["legacy_name"] = str(p.legacy_name);
    row["channels"] = str(p.channels);
    row["type"] = str(p.type);
    rows.append(row);
  }
  return rows;
}

}  // namespace

void bind_tables(nb::module_& m) {
  m.def("load_embree", &embree::load, nb::arg("path"),
        "Opens the Embree library at `path`; RuntimeError says why it cannot.");
  m.def("parameter_rows", &parameter_rows, "The table of settings, a dict per row.");
  m.def("start_recording", &embree::start_recording, nb::arg("capacity"),
        "Scenes compiled from now on keep their rays; render them on one thread.");
  m.def("stop_recording", &embree::stop_recording);
  m.def(
      "replay",
      [] {
        const embree::ReplayResult r = embree::replay();
        return nb::make_tuple(r.rays, r.seconds, r.hits);
      },
      "Casts the recorded rays again on one thread: (rays, seconds, hits).");
  m.def("pass_rows", &pass_rows, "The table of passes, a dict per row.");
}

}  // namespace vernier
