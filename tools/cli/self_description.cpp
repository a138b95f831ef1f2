// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/self_description.h"

#include <cctype>
#include <functional>
#include <utility>
#include <vector>

#include "rig/types.h"

namespace thew::tools {
namespace {

struct OptionWords {
  std::vector<std::string> names;    ///< "--out", "-h"; empty: a positional
  std::string value;                 ///< "OUT"; "": a flag
  std::vector<std::string> choices;  ///< of the value; empty: any
  std::string meaning, default_value;
  bool required = false;
};
struct CommandWords {
  std::string name;  ///< "thew bake"
  std::string meaning;
  std::vector<OptionWords> options;
  std::vector<std::pair<std::string, std::string>> commands;  ///< below it: name, meaning
};

// "auto, bar or none" and "TEXT:{fail,warn}" as their words.
std::vector<std::string> words_in(const std::string& text, const std::string& ends) {
  std::vector<std::string> words(1);
  for (const char c : text) {
    if (ends.find(c) == ends.npos) {
      words.back() += c;
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  std::erase(words, "or");
  return words;
}

// Whose meaning is the list of its words.
bool is_progress(const OptionWords& option) {
  return !option.names.empty() && option.names.front() == "--progress";
}

OptionWords words_of(const CLI::Option& option) {
  OptionWords words;
  for (const std::string& name : option.get_lnames()) words.names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) words.names.push_back("-" + name);
  words.meaning = option.get_description();
  words.required = option.get_required();
  words.default_value = option.get_default_str();
  if (option.get_items_expected_max() == 0) return words;
  words.value = words.names.empty() ? option.get_name() : words.names.front().substr(2);
  for (char& c : words.value) c = c == '-' ? '_' : static_cast<char>(std::toupper(c));
  const std::string type = option.get_type_name();
  if (const size_t open = type.find('{'); open != type.npos) {
    words.choices = words_in(type.substr(open + 1, type.find('}') - open - 1), ",");
  }
  if (is_progress(words)) words.choices = words_in(words.meaning, ", ");
  return words;
}

// Of the program and all commands, each after the one that it is below.
void collect(const CLI::App& command, const std::string& name, std::vector<CommandWords>& all) {
  CommandWords words{name, command.get_description(), {}, {}};
  for (const CLI::Option* option : command.get_options())
    words.options.push_back(words_of(*option));
  const auto below = command.get_subcommands({});
  for (const CLI::App* one : below) {
    words.commands.emplace_back(one->get_name(), one->get_description());
  }
  all.push_back(std::move(words));
  for (const CLI::App* one : below) collect(*one, name + " " + one->get_name(), all);
}

std::vector<CommandWords> commands_of(const CLI::App& app) {
  std::vector<CommandWords> all;
  collect(app, app.get_name(), all);
  return all;
}

std::string replaced(const std::string& text, const std::function<std::string(char)>& with) {
  std::string out;
  for (const char c : text) out += with(c);
  return out;
}

// Of a manual page: no word of it is a request, and no hyphen is another sign than the one typed.
std::string roff(const std::string& text) {
  const std::string safe = replaced(text, [](char c) -> std::string {
    return c == '-' ? "\\-" : c == '\\' ? "\\e" : c == '\'' ? "\\(aq" : std::string(1, c);
  });
  return safe.starts_with('.') ? "\\&" + safe : safe;
}

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string slanted(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

std::string roff_option(const OptionWords& option) {
  std::string names, meaning = roff(option.meaning);
  for (const std::string& name : option.names) names += (names.empty() ? "" : ", ") + bold(name);
  if (!option.value.empty()) names += (names.empty() ? "" : " ") + slanted(option.value);
  std::string choices;
  for (const std::string& one : option.choices) choices += (choices.empty() ? "" : ", ") + one;
  if (!choices.empty() && !is_progress(option)) {
    meaning += (meaning.empty() ? "" : "; ") + roff(choices);
  }
  if (!option.default_value.empty()) meaning += roff("; " + option.default_value + " by default");
  return ".TP\n" + names + "\n" + (meaning.empty() ? "\\&" : meaning) + "\n";
}

std::string synopsis_of(const CommandWords& command) {
  std::string line = bold(command.name), options;
  for (const OptionWords& option : command.options) {
    if (option.names.empty()) {
      line += " " + slanted(option.value);
    } else if (option.required) {
      line += " " + bold(option.names.front()) + " " + slanted(option.value);
    }
  }
  return line + (command.commands.empty() ? " [" : " " + slanted("COMMAND") + " [") +
         slanted("options") + "]";
}

std::string roff_of(const CommandWords& command) {
  std::string text = ".SS " + synopsis_of(command) + "\n" + roff(command.meaning) + "\n";
  for (const OptionWords& option : command.options) {
    if (option.names != std::vector<std::string>{"--help", "-h"}) text += roff_option(option);
  }
  return text;
}

// "Exit codes: 0 done; 1 compared ..." as a list.
std::string roff_of_codes(const std::string& footer) {
  std::string text;
  for (const std::string& code : words_in(footer.substr(footer.find(':') + 1), ";")) {
    std::string line = replaced(code, [](char c) { return std::string(1, c == '\n' ? ' ' : c); });
    line.erase(0, line.find_first_not_of(' '));
    const size_t blank = line.find(' ');
    text += ".TP\n" + bold(line.substr(0, blank)) + "\n" + roff(line.substr(blank + 1)) + "\n";
  }
  return text;
}

// As one word of a shell.
std::string quoted(const std::string& text) {
  return "'" + replaced(text, [](char c) { return c == '\'' ? "'\\''" : std::string(1, c); }) + "'";
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

// "thew bake | thew golden update": what the words before the cursor may have become.
std::string known_commands(const std::vector<CommandWords>& all) {
  std::string text;
  for (size_t i = 1; i < all.size(); ++i) text += (i > 1 ? "|" : "") + quoted(all[i].name);
  return text;
}

// The branches `bash` and `zsh` have in common: after an option with a choice, its words.
std::string choice_branches(const std::vector<CommandWords>& all, const std::string& offer,
                            const std::string& end) {
  std::string text;
  for (const CommandWords& command : all) {
    for (const OptionWords& option : command.options) {
      if (option.choices.empty() || option.names.empty()) continue;
      text += "    " + quoted(command.name + " " + option.names.front()) + ") " + offer +
              joined(option.choices) + end + "; return ;;\n";
    }
  }
  return text;
}

std::string bash_completion(const std::vector<CommandWords>& all) {
  std::string text =
      "# bash completion for thew, as thew --completion bash writes it\n_thew() {\n"
      "  local cur=$2 prev=$3 word words='' command=thew\n"
      "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
      "    case \"$command $word\" in\n      " +
      known_commands(all) +
      ") command+=\" $word\" ;;\n    esac\n  done\n"
      "  COMPREPLY=()\n  case \"$command $prev\" in\n" +
      choice_branches(all, "COMPREPLY=($(compgen -W '", "' -- \"$cur\"))") +
      "  esac\n  case \"$command\" in\n";
  for (const CommandWords& command : all) {
    std::vector<std::string> commands, options;
    for (const auto& [name, meaning] : command.commands) commands.push_back(name);
    for (const OptionWords& option : command.options) {
      options.insert(options.end(), option.names.begin(), option.names.end());
    }
    text += "    " + quoted(command.name) + ")\n      words=" + quoted(joined(commands)) +
            "\n      [[ $cur == -* ]] && words=" + quoted(joined(options)) + " ;;\n";
  }
  // Without words files are completed.
  return text +
         "  esac\n  [[ -z $words ]] || COMPREPLY=($(compgen -W \"$words\" -- \"$cur\"))\n"
         "}\ncomplete -o default -F _thew thew\n";
}

std::string zsh_completion(const std::vector<CommandWords>& all) {
  const auto described = [](const std::string& name, const std::string& meaning) {
    return " " + quoted(name + ":" + meaning);
  };
  std::string text =
      "#compdef thew\n# As thew --completion zsh writes it.\n"
      "local word command=thew\nlocal -a offered\n"
      "for word in ${words[2,CURRENT-1]}; do\n  case \"$command $word\" in\n    " +
      known_commands(all) +
      ") command+=\" $word\" ;;\n  esac\ndone\n"
      "case \"$command ${words[CURRENT-1]}\" in\n" +
      choice_branches(all, "compadd -- ", "") + "esac\ncase $command in\n";
  for (const CommandWords& command : all) {
    std::string commands, options;
    for (const auto& [name, meaning] : command.commands) commands += described(name, meaning);
    for (const OptionWords& option : command.options) {
      for (const std::string& name : option.names) options += described(name, option.meaning);
    }
    text += "  " + quoted(command.name) + ")\n    offered=(" + commands +
            " )\n    [[ $PREFIX == -* ]] && offered=(" + options + " ) ;;\n";
  }
  return text + "esac\nif (( $#offered )); then\n  _describe thew offered\nelse\n  _files\nfi\n";
}

std::string fish_completion(const std::vector<CommandWords>& all) {
  std::string text =
      "# fish completion for thew, as thew --completion fish writes it\n"
      "function __thew_is\n  set -l command thew\n"
      "  for word in (commandline -opc)[2..-1]\n"
      "    switch \"$command $word\"\n      case";
  for (size_t i = 1; i < all.size(); ++i) text += " " + quoted(all[i].name);
  text +=
      "\n        set command \"$command $word\"\n    end\n  end\n"
      "  test \"$command\" = \"$argv\"\nend\n";
  for (const CommandWords& command : all) {
    const std::string line = "complete -c thew -n " + quoted("__thew_is " + command.name);
    for (const auto& [name, meaning] : command.commands) {
      text += line + " -f -a " + name + " -d " + quoted(meaning) + "\n";
    }
    for (const OptionWords& option : command.options) {
      if (option.names.empty()) continue;
      text += line;
      for (const std::string& name : option.names) {
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      }
      if (!option.value.empty()) text += " -r";
      if (!option.choices.empty()) text += " -f -a " + quoted(joined(option.choices));
      text += " -d " + quoted(option.meaning) + "\n";
    }
  }
  return text;
}

}  // namespace

std::string man_page(const CLI::App& app, const std::string& name, const std::string& version) {
  const std::vector<CommandWords> all = commands_of(app);
  std::string text =
      ".TH " +
      replaced(name, [](char c) { return std::string(1, static_cast<char>(std::toupper(c))); }) +
      " 1 \"\" " + "\"" + roff(version) + "\"\n.SH NAME\n" + roff(name) +
      " \\- muscles and skin of animated characters\n.SH SYNOPSIS\n" + synopsis_of(all.front()) +
      "\n.SH DESCRIPTION\n" + roff(app.get_description()) + "\n";
  for (const OptionWords& option : all.front().options) text += roff_option(option);
  text += ".SH COMMANDS\n";
  for (size_t i = 1; i < all.size(); ++i) text += roff_of(all[i]);
  return text + ".SH EXIT STATUS\n" + roff_of_codes(app.get_footer());
}

std::string completion(const CLI::App& app, const std::string& shell) {
  const std::vector<CommandWords> all = commands_of(app);
  if (shell == "bash") return bash_completion(all);
  if (shell == "zsh") return zsh_completion(all);
  if (shell == "fish") return fish_completion(all);
  throw Error(ErrorCode::kUsage, "--completion " + shell + ": give bash, zsh or fish");
}

}  // namespace thew::tools
