// SPDX-License-Identifier: Apache-2.0
#include "rig/import/urdf_tree.h"

#include <tinyxml.h>

#include <algorithm>

#include "rig/text.h"

namespace thew::rig {
namespace {

constexpr int kDepthLimit = 200;  // tinyxml recurses: some ten thousand levels overflow the stack
constexpr size_t kLinkLimit = 4096;  // far above any rig; the searches below are linear

// The depth to which elements are nested, by the rules of tinyxml: quotes count inside a tag only,
// comments end at -->, character data at ]]>, and other declarations at the first >.
int nesting_depth(const std::string& text) {
  int depth = 0, deepest = 0;
  const auto after = [&](const char* end, size_t from) {
    const size_t at = text.find(end, from);
    return at == text.npos ? text.size() : at + std::string_view(end).size();
  };
  for (size_t i = text.find('<'); i < text.size(); i = text.find('<', i)) {
    const std::string_view begin = std::string_view(text).substr(i, 9);
    if (begin.starts_with("<!--")) {
      i = after("-->", i);
    } else if (begin.starts_with("<![CDATA[")) {
      i = after("]]>", i);
    } else if (begin.starts_with("<!") || begin.starts_with("<?")) {
      i = after(">", i);
    } else if (begin.starts_with("</")) {
      depth = std::max(0, depth - 1);
      i = after(">", i);
    } else {
      deepest = std::max(deepest, ++depth);
      for (++i; i < text.size() && text[i] != '>'; ++i) {
        if (text[i] == '"' || text[i] == '\'') i = std::min(text.find(text[i], i + 1), text.size());
      }
      if (i < text.size() && text[i - 1] == '/') --depth;
    }
  }
  return deepest;
}

std::string attribute(const TiXmlElement& element, const char* name) {
  const char* text = element.Attribute(name);
  return text ? text : "";
}

void read_links(UrdfTree& tree, const TiXmlElement& robot) {
  for (auto* e = robot.FirstChildElement("link"); e; e = e->NextSiblingElement("link")) {
    UrdfTree::Link link{attribute(*e, "name"), e->Row(), {}};
    if (link.name.empty()) refuse(tree, link.row, "a link has no name; give it one");
    for (const UrdfTree::Link& other : tree.links) {
      if (other.name == link.name) {
        refuse(tree, link.row,
               "link \"" + link.name + "\" is also at line " + std::to_string(other.row) +
                   "; rename one");
      }
    }
    for (auto* v = e->FirstChildElement("visual"); v; v = v->NextSiblingElement("visual")) {
      link.visuals.push_back(v);
    }
    tree.links.push_back(std::move(link));
    if (tree.links.size() > kLinkLimit) {
      refuse(tree, e->Row(), "more than " + std::to_string(kLinkLimit) + " links; this is no rig");
    }
  }
  if (tree.links.empty()) refuse(tree, robot.Row(), "has no links; a rig needs at least one");
}

int link_of(const UrdfTree& tree, const TiXmlElement& joint, const char* side) {
  const std::string subject = "joint \"" + attribute(joint, "name") + "\": ";
  const TiXmlElement* element = joint.FirstChildElement(side);
  const std::string name = element ? attribute(*element, "link") : "";
  std::vector<std::string> names;
  for (size_t i = 0; i < tree.links.size(); ++i) {
    if (tree.links[i].name == name) return static_cast<int>(i);
    names.push_back(tree.links[i].name);
  }
  if (name.empty()) refuse(tree, joint.Row(), subject + "has no <" + side + " link=...>; add it");
  refuse(tree, element->Row(),
         subject + side + " link \"" + name + "\" does not exist" + did_you_mean(name, names) +
             "; add it or correct the name");
}

void read_joints(UrdfTree& tree, const TiXmlElement& robot) {
  for (auto* e = robot.FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) {
    UrdfTree::Joint joint{attribute(*e, "name"), e->Row(), e, -1, -1};
    if (joint.name.empty()) refuse(tree, joint.row, "a joint has no name; give it one");
    const std::string subject = "joint \"" + joint.name + "\": ";
    if (e->FirstChildElement("mimic")) {
      refuse(tree, joint.row, subject + "mimic is not supported; drive the joint by the clip");
    }
    joint.parent = link_of(tree, *e, "parent");
    joint.child = link_of(tree, *e, "child");
    for (const UrdfTree::Joint& other : tree.joints) {
      if (other.name == joint.name) {
        refuse(tree, joint.row,
               subject + "is also at line " + std::to_string(other.row) + "; rename one");
      }
      if (other.child == joint.child) {
        refuse(tree, joint.row,
               subject + "link \"" + tree.links[joint.child].name + "\" hangs on joint \"" +
                   other.name + "\" already; remove one");
      }
    }
    tree.joints.push_back(joint);
  }
}

// Each link is the child of at most one joint here, so the links form a tree if there is one root
// and all are reached from it.
void order_bodies(UrdfTree& tree) {
  std::vector<int> joint_above(tree.links.size(), -1);
  for (size_t j = 0; j < tree.joints.size(); ++j) {
    joint_above[tree.joints[j].child] = static_cast<int>(j);
  }
  for (size_t i = 0; i < tree.links.size(); ++i) {
    if (joint_above[i] >= 0) continue;
    if (!tree.bodies.empty()) {
      refuse(tree, tree.links[i].row,
             "links \"" + tree.links[tree.bodies[0].link].name + "\" and \"" + tree.links[i].name +
                 "\" are both roots; join them by a fixed joint");
    }
    tree.bodies.push_back({static_cast<int>(i), -1, -1});
  }
  for (size_t b = 0; b < tree.bodies.size(); ++b) {
    for (size_t j = 0; j < tree.joints.size(); ++j) {
      if (tree.joints[j].parent != tree.bodies[b].link) continue;
      tree.bodies.push_back({tree.joints[j].child, static_cast<int>(b), static_cast<int>(j)});
    }
  }
  if (tree.bodies.size() == tree.links.size()) return;
  std::vector<bool> reached(tree.links.size(), false);
  for (const UrdfTree::Body& body : tree.bodies) reached[body.link] = true;
  const size_t lost = std::find(reached.begin(), reached.end(), false) - reached.begin();
  refuse(tree, tree.links[lost].row,
         "link \"" + tree.links[lost].name +
             "\" is in or below a cycle of joints; cut the cycle at joint \"" +
             tree.joints[joint_above[lost]].name + "\"");
}

}  // namespace

UrdfTree read_urdf_tree(const std::filesystem::path& file, const std::string& text) {
  UrdfTree tree;
  tree.file = file.string();
  if (text.find('\0') != text.npos) refuse(tree, 1, "holds a zero byte; save it as XML text");
  if (nesting_depth(text) > kDepthLimit) {
    refuse(tree, 1,
           "its elements are nested deeper than " + std::to_string(kDepthLimit) +
               " levels; this is not a URDF");
  }
  tree.document = std::make_shared<TiXmlDocument>();
  tree.document->Parse(text.c_str());
  if (tree.document->Error()) {
    refuse(tree, tree.document->ErrorRow(),
           std::string("is not well-formed XML: ") + tree.document->ErrorDesc() + "; correct it");
  }
  const TiXmlElement* robot = tree.document->FirstChildElement("robot");
  if (!robot) refuse(tree, 1, "has no <robot> element; name a URDF");
  read_links(tree, *robot);
  read_joints(tree, *robot);
  order_bodies(tree);
  return tree;
}

void refuse(const UrdfTree& tree, int row, const std::string& what) {
  throw Error(ErrorCode::kInput, tree.file + ":" + std::to_string(std::max(row, 1)) + ": " + what);
}

}  // namespace thew::rig
