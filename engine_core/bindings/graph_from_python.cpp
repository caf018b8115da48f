#include "bindings/graph_from_python.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <stdexcept>

namespace nb = nanobind;

namespace vernier {
namespace {

// A link has a node and an output; every other value has not.
bool is_link(nb::handle value) { return nb::hasattr(value, "node"); }

NodeLink read_link(nb::handle link) {
  return {nb::cast<int32_t>(nb::int_(link.attr("node"))),
          nb::cast<std::string>(link.attr("output"))};
}

// A scalar goes to the first channel; of sequences up to four numbers are read.
NodeInput read_input(const std::string& node, std::string name, nb::handle value) {
  NodeInput input;
  input.name = std::move(name);
  if (is_link(value)) {
    const NodeLink link = read_link(value);
    input.node = link.node;
    input.output = link.output;
    return input;
  }
  try {
    if (!nb::isinstance<nb::sequence>(value)) {
      input.value[0] = nb::cast<float>(nb::float_(value));
      return input;
    }
    size_t i = 0;
    for (nb::handle item : value) {
      if (i == input.value.size()) {
        break;
      }
      input.value[i++] = nb::cast<float>(nb::float_(item));
    }
  } catch (const std::exception&) {
    throw std::invalid_argument("node '" + node + "': input '" + input.name +
                                "' is neither a link nor numbers");
  }
  return input;
}

using FloatView = nb::ndarray<const float, nb::c_contig, nb::device::cpu>;

ParamValue read_param(const std::string& node, const std::string& name, nb::handle value) {
  if (nb::isinstance<nb::bool_>(value)) {
    return nb::cast<bool>(value);
  }
  if (nb::isinstance<nb::str>(value)) {
    return nb::cast<std::string>(value);
  }
  if (nb::isinstance<nb::int_>(value)) {
    return nb::cast<int64_t>(value);
  }
  if (nb::isinstance<nb::float_>(value)) {
    return nb::cast<double>(value);
  }
  if (FloatView array; nb::try_cast(value, array)) {
    return std::vector<float>(array.data(), array.data() + array.size());
  }
  if (nb::isinstance<nb::sequence>(value)) {
    std::vector<float> floats;
    for (nb::handle item : value) {
      floats.push_back(nb::cast<float>(nb::float_(item)));
    }
    return floats;
  }
  throw std::invalid_argument("node '" + node + "': parameter '" + name +
                              "' is no bool, number, string or float array");
}

NodeDesc read_node(nb::handle source) {
  NodeDesc node;
  node.kind = nb::cast<std::string>(source.attr("kind"));
  node.name = nb::cast<std::string>(source.attr("name"));
  for (auto [name, value] : nb::cast<nb::dict>(source.attr("inputs"))) {
    node.inputs.push_back(read_input(node.name, nb::cast<std::string>(name), value));
  }
  for (auto [name, value] : nb::cast<nb::dict>(source.attr("params"))) {
    const auto key = nb::cast<std::string>(name);
    node.params.emplace(key, read_param(node.name, key, value));
  }
  return node;
}

}  // namespace

GraphDesc graph_from_python(nb::handle source) {
  GraphDesc graph;
  for (nb::handle node : source.attr("nodes")) {
    graph.nodes.push_back(read_node(node));
  }
  nb::object surface = source.attr("surface");
  if (!surface.is_none()) {
    graph.surface = read_link(surface);
  }
  return graph;
}

}  // namespace vernier
