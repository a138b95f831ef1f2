// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

class TiXmlDocument;
class TiXmlElement;

namespace thew::rig {

/// The links and joints of a URDF with their lines, and the tree that they form, which urdfdom does
/// not check. Private to the library.
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

/// Throws Error(kInput) if the text is no XML or nested too deeply, a name is unknown or used
/// twice, a joint has a mimic, or the links form no tree.
UrdfTree read_urdf_tree(const std::filesystem::path& file, const std::string& text);

/// Throws Error(kInput): "file:row: what".
[[noreturn]] void refuse(const UrdfTree& tree, int row, const std::string& what);

}  // namespace thew::rig
