// The parts of the table of node kinds, by topic, and words to write them with.
#pragma once

#include <vector>

#include "nodes/lowering.h"
#include "nodes/node_kinds.h"

namespace vernier {

std::vector<NodeKind> closure_node_kinds();
std::vector<NodeKind> math_node_kinds();
std::vector<NodeKind> vector_node_kinds();
std::vector<NodeKind> color_node_kinds();
std::vector<NodeKind> input_node_kinds();
std::vector<NodeKind> normal_node_kinds();
std::vector<NodeKind> texture_node_kinds();
std::vector<NodeKind> image_node_kinds();

inline InputKind float_input(std::string_view name, float value) {
  return {name, SocketType::kFloat, {value, 0, 0, 0}, SocketSource::kValue};
}
inline InputKind vector_input(std::string_view name, float x = 0, float y = 0, float z = 0) {
  return {name, SocketType::kVector, {x, y, z, 0}, SocketSource::kValue};
}
inline InputKind vector_input(std::string_view name, SocketSource source) {
  return {name, SocketType::kVector, {}, source};
}
inline InputKind color_input(std::string_view name, float r, float g, float b) {
  return {name, SocketType::kColor, {r, g, b, 1}, SocketSource::kValue};
}
inline InputKind color_input(std::string_view name, float grey) {
  return color_input(name, grey, grey, grey);
}
inline InputKind shader_input(std::string_view name) {
  return {name, SocketType::kShader, {}, SocketSource::kValue};
}
inline OutputKind float_output(std::string_view name) { return {name, SocketType::kFloat}; }
inline OutputKind vector_output(std::string_view name) { return {name, SocketType::kVector}; }
inline OutputKind color_output(std::string_view name) { return {name, SocketType::kColor}; }
inline OutputKind shader_output(std::string_view name) { return {name, SocketType::kShader}; }

inline ParamKind bool_param(std::string_view name, bool value) {
  return {name, ParamType::kBool, value ? 1.0 : 0.0, {}};
}
inline ParamKind int_param(std::string_view name, int value) {
  return {name, ParamType::kInt, static_cast<double>(value), {}};
}
inline ParamKind float_param(std::string_view name, double value) {
  return {name, ParamType::kFloat, value, {}};
}
inline ParamKind string_param(std::string_view name) { return {name, ParamType::kString, 0, {}}; }
inline ParamKind floats_param(std::string_view name) { return {name, ParamType::kFloats, 0, {}}; }
inline ParamKind image_param(std::string_view name) { return {name, ParamType::kImage, -1, {}}; }
inline ParamKind enum_param(std::string_view name, std::vector<std::string_view> items) {
  return {name, ParamType::kEnum, 0, std::move(items)};
}

}  // namespace vernier
