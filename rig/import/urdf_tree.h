// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

class TiXmlDocument;
class TiXmlElement;

namespace thew::rig {

/// What urdfdom does not tell: the lines of a URDF's links and joints, and whether they form one
/// tree. Private to the library.
struct UrdfTree {
  struct Link {
    std::string name;
    int row;  ///< line of the file
    std::vector<const TiXmlElement*> visuals;
  };
  struct Joint {
    std::string name;
    int row;
    const TiXmlElement* element;
    int parent, child;  ///< links
  };
  struct Body {
    int link;
    int parent;  ///< body, earlier in the list; -1: the root
    int joint;   ///< -1: the root
  };
  std::string file;
  std::shared_ptr<TiXmlDocument> document;  ///< owns the elements
  std::vector<Link> links;
  std::vector<Joint> joints;
  std::vector<Body> bodies;  ///< breadth first from the root, joints in the file's order
};

/// Throws Error(kInput): nested too deep, not XML, a name twice or unknown, mimic, no tree.
UrdfTree read_urdf_tree(const std::filesystem::path& file, const std::string& text);

/// Throws Error(kInput): "file:row: what".
[[noreturn]] void refuse(const UrdfTree& tree, int row, const std::string& what);

}  // namespace thew::rig
