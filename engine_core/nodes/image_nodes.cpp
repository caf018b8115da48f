// Image and Environment Texture: table and lowering.
#include "nodes/image_ops.h"
#include "nodes/node_tables.h"

namespace vernier {
namespace {

enum class InterpolationItem { kLinear, kClosest, kCubic, kSmart };

Interpolation interpolation_of(NodeLowering& node) {
  switch (node.param_enum<InterpolationItem>("interpolation")) {
    case InterpolationItem::kLinear:
      return Interpolation::kLinear;
    case InterpolationItem::kClosest:
      return Interpolation::kClosest;
    // Smart is cubic in Cycles too.
    case InterpolationItem::kCubic:
    case InterpolationItem::kSmart:
      break;
  }
  return Interpolation::kCubic;
}

// The image that a node names, and a warning where it has none.
const ImageTexture* image_of(NodeLowering& node) {
  const ImageTexture* image = node.context().image(node.param_int("image"));
  if (image == nullptr || image->missing()) {
    node.warn(image == nullptr ? "it has no image; it is drawn magenta"
                               : "image '" + image->name() + "' is missing; it is drawn magenta");
  }
  return image;
}

void set_outputs(NodeLowering& node, Value color) {
  node.set("Color", color);
  if (node.wants("Alpha")) {
    node.set("Alpha", node.emit(Op::kExtract, 3, SocketType::kFloat, {color}));
  }
}

void lower_image(NodeLowering& node) {
  enum class Projection { kFlat, kBox, kSphere, kTube };
  const auto projection = node.param_enum<Projection>("projection");
  const ImageTexture* image = image_of(node);
  ImageUse use;
  use.interpolation = interpolation_of(node);
  use.extension = node.param_enum<Extension>("extension");
  // As in Cycles, the colour stays associated with alpha until something reads alpha.
  use.straight = node.wants("Alpha") && image != nullptr && image->has_alpha() &&
                 image->alpha_mode() != AlphaMode::kChannelPacked;
  use.projection = static_cast<uint8_t>(projection == Projection::kSphere ? ImageProjection::kSphere
                                        : projection == Projection::kTube ? ImageProjection::kTube
                                                                          : ImageProjection::kFlat);
  const uint32_t data = node.builder().add_image(image);
  const Value p = node.input("Vector");
  if (projection == Projection::kBox) {
    const Value blend = node.builder().constant(node.param_float("projection_blend"));
    set_outputs(node, node.emit(Op::kImageBox, use.pack(), SocketType::kColor, {p, blend}, data));
  } else {
    set_outputs(node, node.emit(Op::kImage, use.pack(), SocketType::kColor, {p}, data));
  }
}

void lower_environment(NodeLowering& node) {
  ImageUse use;
  use.interpolation = interpolation_of(node);
  use.projection = static_cast<uint8_t>(node.param_enum<EnvironmentProjection>("projection"));
  const uint32_t data = node.builder().add_image(image_of(node));
  set_outputs(node, node.emit(Op::kEnvironment, use.pack(), SocketType::kColor,
                              {node.input("Vector")}, data));
}

}  // namespace

// `image` is an index into the description's images.
std::vector<NodeKind> image_node_kinds() {
  std::vector<NodeKind> kinds;
  kinds.push_back(
      {"ShaderNodeTexImage",
       NodeRole::kValue,
       lower_image,
       {vector_input("Vector", SocketSource::kUv)},
       {color_output("Color"), float_output("Alpha")},
       {image_param("image"), enum_param("projection", {"FLAT", "BOX", "SPHERE", "TUBE"}),
        float_param("projection_blend", 0.0),
        enum_param("interpolation", {"Linear", "Closest", "Cubic", "Smart"}),
        enum_param("extension", {"REPEAT", "EXTEND", "CLIP", "MIRROR"})},
       {}});
  kinds.push_back(
      {"ShaderNodeTexEnvironment",
       NodeRole::kValue,
       lower_environment,
       {vector_input("Vector", SocketSource::kPosition)},
       {color_output("Color")},
       {image_param("image"), enum_param("projection", {"EQUIRECTANGULAR", "MIRROR_BALL"}),
        enum_param("interpolation", {"Linear", "Closest", "Cubic", "Smart"})},
       {}});
  return kinds;
}

}  // namespace vernier
