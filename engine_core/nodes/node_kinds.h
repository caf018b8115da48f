// The declarative table of node kinds: one description that validation, lowering, reports to the
// user and the add-on's translator share.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

namespace vernier {

enum class SocketType : uint8_t { kFloat, kVector, kColor, kShader };

// What an unlinked input reads. kValue: the input's constant; the others ignore any constant.
enum class SocketSource : uint8_t { kValue, kNormal, kTangent, kGenerated, kUv, kPosition };

enum class ParamType : uint8_t {
  kBool,
  kInt,
  kFloat,
  kString,
  kEnum,
  kFloats,  // a flat array of floats; its rows are told by the parameter's documentation
  kImage,   // index into SceneDescription::images, -1: none
};

struct InputKind {
  std::string_view name;  // Blender's socket identifier
  SocketType type = SocketType::kFloat;
  std::array<float, 4> value{};
  SocketSource source = SocketSource::kValue;
};

struct OutputKind {
  std::string_view name;
  SocketType type = SocketType::kFloat;
};

struct ParamKind {
  std::string_view name;  // RNA property, or the form that description.py gives it
  ParamType type = ParamType::kBool;
  double number = 0;                    // default of kBool, kInt, kFloat, kImage
  std::vector<std::string_view> items;  // kEnum: identifiers; the first one is the default
};

class NodeLowering;

// What a node is to the compiler. Mix and Add Shader become weights of closures.
enum class NodeRole : uint8_t { kValue, kClosure, kMixShader, kAddShader };

struct NodeKind {
  std::string_view name;  // bl_idname
  NodeRole role = NodeRole::kValue;
  // Emits the node's instructions (kValue) or its closures (kClosure).
  void (*lower)(NodeLowering&) = nullptr;
  std::vector<InputKind> inputs;
  std::vector<OutputKind> outputs;
  std::vector<ParamKind> params;
  // Empty, or what this kind, which the core only approximates, is replaced by.
  std::string_view fallback;
};

// All kinds, in order of name.
std::span<const NodeKind> node_kinds();
// The kind called `name`, or null.
const NodeKind* find_node_kind(std::string_view name);

}  // namespace vernier
