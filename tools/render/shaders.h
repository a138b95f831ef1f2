// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

/// The files of tools/render/shaders, GLSL 3.30 core, embedded when the library is built. All is in
/// view space (the eye at 0, looking along -z) unless it says world. Colours are stored as square
/// roots of light (gamma 2: cheap, and near enough to sRGB).
namespace thew::tools {

extern const char *const kScreenVert,
    *const kShadowVert, *const kShadowFrag, *const kCutShadowVert,
                                                *const kCutShadowFrag,
                                                    *const kSurfaceVert,
                                                        *const kSurfaceFrag,
                                                            *const kOcclusionFrag,
                                                                *const kLightFrag,
                                                                    *const kPictureFrag;

/// kSurfaceFrag for one look.
inline std::string surface_source(int look) {
  std::string source = kSurfaceFrag;  // no define may stand before the version
  const std::size_t behind_version = source.find('\n', source.find("#version")) + 1;
  return source.insert(behind_version, "#define LOOK " + std::to_string(look) + "\n");
}

}  // namespace thew::tools
