// SPDX-License-Identifier: Apache-2.0
#include "muscles/ring_springs.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "rig/vectorise.h"

namespace thew::muscles {
namespace {

// Springs by their two ends. Each end takes each spring once, because two edges of a small mesh may
// have the same opposite vertices.
using SpringsByEnds = std::map<std::array<int, 2>, std::vector<int>>;

struct Ring {
  std::vector<int> other, spring;  // by edge of the node, then by opposite vertex
};

int take(SpringsByEnds& by_ends, int a, int b) {
  const auto found = by_ends.find({a, b});
  if (found == by_ends.end() || found->second.empty()) return -1;
  const int spring = found->second.back();
  found->second.pop_back();
  return spring;
}

// `third` has the third corner of the triangle on the left of each directed edge.
Ring ring_of(int node, int first, const std::map<std::array<int, 2>, int>& third,
             SpringsByEnds& edges, SpringsByEnds& opposites) {
  Ring ring;
  int at = first;
  do {
    ring.other.push_back(at);
    ring.spring.push_back(take(edges, node, at));
    at = third.at({node, at});
  } while (at != first);
  const size_t degree = ring.other.size();
  for (size_t j = 0; j < degree; ++j) {
    const int a = ring.other[j], b = ring.other[(j + 1) % degree];
    const int opposite = third.at({b, a});
    const int spring = opposite == node ? -1 : take(opposites, node, opposite);
    ring.other.push_back(spring < 0 ? a
                                    : opposite);  // where there is no spring, any node but this one
    ring.spring.push_back(spring);
  }
  return ring;
}

void add_slice(const std::vector<Ring>& rings, const std::vector<int>& nodes, size_t from,
               const Springs& springs, RingSprings& out) {
  RingSprings::Slice slice;
  slice.degree = static_cast<int>(rings[nodes[from]].other.size()) / 2;
  slice.first = static_cast<int>(out.other.size());
  slice.at = static_cast<int>(from);
  for (int lane = 0; lane < kLanes; ++lane) {
    const size_t at = from + lane;
    const bool counts = at < nodes.size() && slice.count == lane &&
                        rings[nodes[at]].other.size() == 2u * slice.degree;
    slice.node[lane] = counts ? nodes[at] : slice.node[lane - 1];
    slice.count += counts;
  }
  for (int j = 0; j < 2 * slice.degree; ++j) {
    RingSprings::Indices other, spring;
    Lanes stiffness, rest_length;
    for (int lane = 0; lane < kLanes; ++lane) {
      const Ring& ring = rings[slice.node[lane]];
      const int k = spring[lane] = ring.spring[j];
      other[lane] = ring.other[j];
      stiffness[lane] = k < 0 ? 0.0 : springs.stiffness[k];
      rest_length[lane] = k < 0 ? 0.0 : springs.rest_length[k];
    }
    out.other.push_back(other);
    out.spring.push_back(spring);
    out.stiffness.push_back(stiffness);
    out.rest_length.push_back(rest_length);
  }
  out.slices.push_back(slice);
}

[[gnu::always_inline]] inline void add_cross(const Lanes3& a, const Lanes3& b, Lanes3& sum) {
  sum.x += a.y * b.z - a.z * b.y;
  sum.y += a.z * b.x - a.x * b.z;
  sum.z += a.x * b.y - a.y * b.x;
}

// Calls work.slice for each slice, with the degree as a template argument for the common degrees.
// That saves a third of the time.
template <typename Work>
[[gnu::always_inline]] inline void each_slice(const RingSprings& rings, RingSprings::Range of,
                                              const Work& work) {
  for (size_t s = of.first; s < of.last; ++s) {
    const RingSprings::Slice& at = rings.slices[s];
    switch (at.degree) {
      case 4:
        work.template slice<4>(at);
        break;
      case 5:
        work.template slice<5>(at);
        break;
      case 6:
        work.template slice<6>(at);
        break;
      case 7:
        work.template slice<7>(at);
        break;
      case 8:
        work.template slice<8>(at);
        break;
      default:
        work.template slice<0>(at);
    }
  }
}

template <bool kGradient>
struct RingPass {
  const RingSprings& rings;
  const Lanes* rest_length;
  const Point *x, *v;
  double dashpot;
  Point *f, *gradient;

  // sum += k (1 + (dashpot rate - L) / |d|) d, with rate = d . w / |d| and w the difference of the
  // velocities.
  [[gnu::always_inline]] void add_spring(int slot, const Lanes3& d, const Lanes3& u,
                                         Lanes3& sum) const {
    const Lanes3 w = minus(gather(v, rings.other[slot].data()), u);
    const Lanes squared = dot(d, d);
    const Lanes length = root(squared);
    const Lanes rate = dashpot * dot(d, w);
    const Lanes pull =
        rings.stiffness[slot] * ((squared - rest_length[slot] * length + rate) / squared);
    sum.x += pull * d.x;
    sum.y += pull * d.y;
    sum.z += pull * d.z;
  }

  // The gradient is a third of the area vector of the ring. The ring is cut into quads from its
  // first corner; twice the area vector of a quad is the cross product of its diagonals. Each quad
  // is added as soon as its corners are loaded, so that only the first and the last two corners
  // stay in registers.
  template <int kDegree>
  [[gnu::always_inline]] void slice(const RingSprings::Slice& at) const {
    const int degree = kDegree > 0 ? kDegree : at.degree;
    const Lanes3 p = gather(x, at.node.data()), u = gather(v, at.node.data());
    Lanes3 sum = {}, area = {}, first = {}, last = {}, before = {};
#pragma GCC unroll 8
    for (int j = 0; j < degree; ++j) {
      const Lanes3 d = minus(gather(x, rings.other[at.first + j].data()), p);
      if (kGradient) {
        if (j == 0) first = d;
        if (j >= 3 && j % 2) add_cross(minus(last, first), minus(d, before), area);
        if (j + 1 == degree && degree % 2) add_cross(minus(last, first), minus(d, first), area);
        before = last;
        last = d;
      }
      add_spring(at.first + j, d, u, sum);
    }
    for (int j = at.first + degree; j < at.first + 2 * degree; ++j) {
      add_spring(j, minus(gather(x, rings.other[j].data()), p), u, sum);
    }
    scatter(sum, at.node.data(), f);
    if (!kGradient) return;
    const Lanes3 third = {area.x * (1.0 / 6.0), area.y * (1.0 / 6.0), area.z * (1.0 / 6.0)};
    scatter(third, at.node.data(), gradient);
  }
};

// f += sum of pull d, with d = x_i - x_j and pull = scale k L / |d|, or scale k if there are no
// rest lengths.
struct RingPull {
  const RingSprings& rings;
  const Lanes* rest_length;
  double scale;
  const Point* x;
  Point* f;

  template <int kDegree>
  [[gnu::always_inline]] void slice(const RingSprings::Slice& at) const {
    const int degree = kDegree > 0 ? kDegree : at.degree;
    const Lanes3 p = gather(x, at.node.data());
    Lanes3 sum = gather(f, at.node.data());
#pragma GCC unroll 8
    for (int j = at.first; j < at.first + 2 * degree; ++j) {
      const Lanes3 d = minus(p, gather(x, rings.other[j].data()));
      Lanes pull = scale * rings.stiffness[j];
      if (rest_length) {
        pull = pull * rest_length[j] / root(dot(d, d));
      }
      sum.x += pull * d.x;
      sum.y += pull * d.y;
      sum.z += pull * d.z;
    }
    scatter(sum, at.node.data(), f);
  }
};

THEW_VECTORISED
void plain_pass(const RingPass<false>& pass, RingSprings::Range of) {
  each_slice(pass.rings, of, pass);
}

THEW_VECTORISED
void gradient_pass(const RingPass<true>& pass, RingSprings::Range of) {
  each_slice(pass.rings, of, pass);
}

THEW_VECTORISED
void pull_pass(const RingPull& pull) { each_slice(pull.rings, {0, pull.rings.free_slices}, pull); }

}  // namespace

RingSprings make_ring_springs(const std::vector<Triangle>& triangles,
                              const std::vector<char>& driven, const Springs& springs) {
  const int nodes = static_cast<int>(driven.size());
  std::map<std::array<int, 2>, int> third;
  std::vector<int> first(nodes, -1);
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      third[{a, b}] = t[(k + 2) % 3];
      if (first[a] < 0) first[a] = b;
    }
  }
  SpringsByEnds edges, opposites;
  for (int k = static_cast<int>(springs.nodes.size()) - 1; k >= 0; --k) {
    const auto [a, b] = springs.nodes[k];
    SpringsByEnds& by_ends = k < springs.structural ? edges : opposites;
    by_ends[{a, b}].push_back(k);
    by_ends[{b, a}].push_back(k);
  }
  std::vector<Ring> rings;
  std::vector<int> order;
  for (int i = 0; i < nodes; ++i) {
    rings.push_back(ring_of(i, first[i], third, edges, opposites));
    order.push_back(i);
  }
  const auto key = [&](int i) { return std::pair(driven[i], rings[i].other.size()); };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  RingSprings out;
  for (size_t at = 0; at < order.size(); at += out.slices.back().count) {
    add_slice(rings, order, at, springs, out);
    if (!driven[order[at]]) out.free_slices = out.slices.size();
  }
  out.order = std::move(order);
  return out;
}

void lengths_by_slot(const RingSprings& rings, const std::vector<double>& by_spring,
                     RingSprings::BySlot& by_slot) {
  by_slot.resize(rings.spring.size());
  for (size_t slot = 0; slot < by_slot.size(); ++slot) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const int k = rings.spring[slot][lane];
      by_slot[slot][lane] = k < 0 ? 0.0 : by_spring[k];
    }
  }
}

void ring_forces(const RingSprings& rings, const RingSprings::BySlot& rest_length,
                 RingSprings::Range of, const Points& x, const Points& v, double dashpot, Points& f,
                 Points* gradient) {
  const auto pass = [&]<bool kGradient>() {
    return RingPass<kGradient>{rings,
                               rest_length.data(),
                               x.data(),
                               v.data(),
                               dashpot,
                               f.data(),
                               gradient ? gradient->data() : nullptr};
  };
  if (gradient) {
    gradient_pass(pass.template operator()<true>(), of);
  } else {
    plain_pass(pass.template operator()<false>(), of);
  }
}

void add_ring_projections(const RingSprings& rings, const RingSprings::BySlot& rest_length,
                          const Points& x, Points& f) {
  pull_pass({rings, rest_length.data(), 1.0, x.data(), f.data()});
}

void add_ring_edges(const RingSprings& rings, double scale, const Points& x, Points& f) {
  pull_pass({rings, nullptr, scale, x.data(), f.data()});
}

}  // namespace thew::muscles
