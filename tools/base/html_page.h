// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace thew::tools {

/// page.css, the style sheet that our pages share: nothing in them comes from a network.
extern const char* const kPageCss;

/// Bytes as text, for what is embedded in a page.
std::string base64(const std::string& bytes);

/// A whole page. `title` is HTML already; `style` is CSS after the shared one; `script` is
/// JavaScript that runs when the page is there.
std::string html_page(const std::string& title, const std::string& style, const std::string& main,
                      const std::string& script = "");
/// Something with a caption under it; nothing around nothing.
std::string html_figure(const std::string& inside, const std::string& caption);
/// A picture that is part of the page: `png` is a file's bytes.
std::string html_png(const std::string& attributes, const std::string& png);

}  // namespace thew::tools
