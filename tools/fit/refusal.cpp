// SPDX-License-Identifier: Apache-2.0
//
// What thew new does not put muscles on, and a picture of why.
#include <algorithm>
#include <cmath>

#include "rig/math.h"
#include "tools/base/svg_chart.h"
#include "tools/fit/target.h"

namespace thew::tools {
namespace {

constexpr double kLeastTold = 0.5;         // of a segment's sections
constexpr double kLeastThick = 0.3;        // of what is usual for the length
constexpr double kLeastVolume = 1.0 / 20;  // of a template's muscle, for the length
// m, of an arm as long as the template's, whose own least is 0.167 mm; in a grown person's 0.1 mm,
// beyond which contact tells nodes apart.
constexpr double kLeastEdge = 1.6e-4;

// By the shorter segment: a robot's upper arm may be half as long as its forearm.
double shorter(const ArmFit& fit) { return std::min(fit.along_upper, fit.along_fore); }

std::string px(const Vec3& p) { return svg_px(p.x()) + "," + svg_px(p.y()); }

// One side of the arm, laid out along x: `up` is unit, at right angles to `along`.
struct Panel {
  Vec3 shoulder, along, up;
  double scale, left, middle;  // px a metre, px
  Vec3 operator()(const Vec3& p) const {
    return {left + scale * along.dot(p - shoulder), middle - scale * up.dot(p - shoulder), 0.0};
  }
};

std::string line_of(const std::vector<Vec3>& points, const std::string& style) {
  std::string path;
  for (const Vec3& p : points) path += (path.empty() ? "M" : " L") + px(p);
  return "<path d=\"" + path + "\" fill=\"none\" " + style + "/>\n";
}

// The skin at one of the directions around the axis, and what is usual.
std::string outlines(const ArmFit& fit, const Panel& panel, int direction) {
  const GirthField& girth = fit.girth;
  const SinCos turn = sin_cos(2.0 * kPi * direction / GirthField::kAround);
  const double elbow = fit.elbow_template.y();
  std::vector<Vec3> usual, measured;
  for (int row = 0; row < girth.rows; ++row) {
    const double y = girth.top - row * GirthField::kRow;
    if (y < fit.wrist_template.y()) break;
    const size_t node = static_cast<size_t>(row) * GirthField::kAround + direction;
    const Vec3 axis = map_point(fit, axis_point(fit, y)),
               out = linear_at(fit, y) * Vec3(turn.cos, 0.0, turn.sin);
    const double along = y > elbow ? fit.along_upper : fit.along_fore;
    usual.push_back(panel(axis + along / fit.across * girth.own[node] * out));
    if (!girth.skin.empty()) measured.push_back(panel(axis + girth.skin[node] * out));
  }
  return line_of(usual, "stroke=\"#06c\" stroke-width=\"1.5\" stroke-dasharray=\"6 4\"") +
         (measured.empty() ? "" : line_of(measured, "stroke=\"#d40\" stroke-width=\"2\""));
}

}  // namespace

double least_edge(const ArmFit& fit) { return kLeastEdge * shorter(fit); }

std::string why_no_arm(const ArmFit& fit, const std::string& side) {
  const GirthField& girth = fit.girth;
  const char* const segments[] = {" upper arm", " forearm"};
  for (int k = 0; k < 2; ++k) {
    const std::string arm = "the " + side + segments[k];
    if (girth.told[k] < kLeastTold) {
      return arm + ": skin is found around its bone in " + readable(100.0 * girth.told[k], 2) +
             " % of its length, too little to tell how thick it is";
    }
    if (girth.thick[k] < kLeastThick) {
      return arm + ": is " + readable(girth.thick[k], 2) +
             " as thick as is usual for its length, too thin for muscles (" +
             readable(kLeastThick) + " is the least)";
    }
  }
  return "";
}

std::string why_thread(const Target& to, const TriMesh& muscle, const MappedSize& size) {
  const double length = shorter(to.fit);
  if (!(size.volume_ratio >= kLeastVolume * length * length * length)) {
    return " has " + readable(1e6 * size.volume) + " cm3, " + readable(size.volume_ratio, 2) +
           " of the template's";
  }
  double least = muscle.vertices.empty() ? 0.0 : 1e3;
  for (const Triangle& t : muscle.triangles) {
    for (int k = 0; k < 3; ++k) {
      least = std::min(least, (muscle.vertices[t[k]] - muscle.vertices[t[(k + 1) % 3]]).norm());
    }
  }
  if (least >= least_edge(to.fit)) return "";
  return " has an edge of " + readable(1e3 * least, 2) + " mm";
}

std::string why_picture(const ArmTemplate& from, const ArmFit& fit, const TriMesh& skin,
                        const std::string& title) {
  constexpr double kWidth = 960.0, kHeight = 700.0, kEdge = 30.0;  // px
  const Vec3 shoulder = fit.elbow - fit.upper * from.elbow,
             wrist = fit.elbow + fit.fore * (from.wrist - from.elbow);
  const Vec3 along = (wrist - shoulder).normalized();
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + svg_px(kWidth) +
                    "\" height=\"" + svg_px(kHeight) +
                    "\" font-family=\"sans-serif\" font-size=\"14\">\n<rect width=\"100%\" "
                    "height=\"100%\" fill=\"#fff\"/>\n" +
                    svg_text(kEdge, kEdge, title) +
                    svg_text(kEdge, kEdge + 20.0,
                             "black: bones; dashed blue: usual for their length; red: the skin as "
                             "measured; grey: the meshes around, from before and from the side",
                             " fill=\"#555\"");
  for (int side = 0; side < 2; ++side) {
    const Vec3 across = fit.frame.col(2 * side);
    const double middle = 230.0 + 310.0 * side;
    const Panel panel{shoulder,
                      along,
                      (across - along.dot(across) * along).normalized(),
                      0.75 * kWidth / (wrist - shoulder).norm(),
                      0.08 * kWidth,
                      middle};
    std::string path;
    for (const Triangle& t : skin.triangles) {
      path += "M" + px(panel(skin.vertices[t[0]])) + "L" + px(panel(skin.vertices[t[1]])) + "L" +
              px(panel(skin.vertices[t[2]])) + "Z";
    }
    out += "<path d=\"" + path +
           "\" fill=\"#888\" fill-opacity=\"0.06\" stroke=\"#888\" stroke-width=\"0.3\"/>\n";
    const int first = side == 0 ? 0 : GirthField::kAround / 4;
    for (const int direction : {first, first + GirthField::kAround / 2}) {
      out += outlines(fit, panel, direction);
    }
    out += line_of({panel(shoulder), panel(fit.elbow), panel(wrist)},
                   "stroke=\"#000\" stroke-width=\"3\"");
  }
  return out + "</svg>\n";
}

}  // namespace thew::tools
