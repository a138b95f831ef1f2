// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/program_main.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>
#include <system_error>

#include "rig/skeleton.h"
#include "rig/text.h"
#include "sim/cache/version.h"
#include "tools/base/large_stack.h"
#include "tools/base/options.h"
#include "tools/base/printing.h"
#include "tools/base/signals.h"
#include "tools/cli/self_description.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExitCodes =
    "Exit codes: 0 done; 1 compared and different, or a bound of the scene not met; 2 usage or "
    "scene;\n3 bad input file; 4 cannot write; 5 the solver could not go on; 75 interrupted, "
    "locked or short of\nmemory or processes: run again";

constexpr const char* kNoMemory = "there is not enough memory; free some and run again";

// Where a standard stream is closed, the next file would take its number, and our messages. What
// stands in for the output cannot be written to, so that print() finds it closed.
void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) >= 0) continue;
    if (::open("/dev/null", stream == STDOUT_FILENO ? O_RDONLY : O_RDWR) < 0) return;
  }
}

std::vector<std::string> subcommands_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* one : command.get_subcommands({})) names.push_back(one->get_name());
  return names;
}

std::vector<std::string> options_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* one : command.get_options()) {
    for (const std::string& name : one->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// The name that a misspelt word stands for: the nearest one, or the only one that begins with it.
std::string meant(const std::string& word, const std::vector<std::string>& names) {
  std::string near = nearest_name(word, names);
  if (!near.empty()) return near;
  const auto begun = [&](const std::string& name) { return name.starts_with(word); };
  if (std::count_if(names.begin(), names.end(), begun) != 1) return "";
  return *std::find_if(names.begin(), names.end(), begun);
}

// What is wrong with the command line. CLI11 would name first what is missing, although a misspelt
// word is often the cause of that.
Error usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = &app;
  std::string name = app.get_name();
  while (command->remaining().empty() && !command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    name += " " + command->get_name();
  }
  const auto refuse = [&](const std::string& what, const std::string& near) {
    return Error(ErrorCode::kUsage,
                 what + (near.empty() ? "; " + name + " --help says what it takes"
                                      : "; did you mean " + near + "?"));
  };
  const std::vector<std::string> unknown = command->remaining();
  if (unknown.empty() && command->get_require_subcommand_min() > 0) {
    return refuse("no command is given", "");
  }
  if (unknown.empty()) return refuse(error.what(), "");
  if (command->get_require_subcommand_min() > 0 && unknown[0][0] != '-') {
    return refuse("\"" + unknown[0] + "\" is no command of " + name,
                  meant(unknown[0], subcommands_of(*command)));
  }
  const auto option = std::find_if(unknown.begin(), unknown.end(), [](const std::string& word) {
    return word.size() > 1 && word[0] == '-';
  });
  if (option == unknown.end()) return refuse("\"" + unknown[0] + "\" is a word too many", "");
  const std::string word = option->substr(0, option->find('='));
  return refuse(word + " is no option of " + name, meant(word, options_of(*command)));
}

std::string command_of(const CLI::App& app) {
  std::string name;
  for (const CLI::App* command = &app; !command->get_subcommands().empty();) {
    command = command->get_subcommands().front();
    name += (name.empty() ? "" : " ") + command->get_name();
  }
  return name;
}

void parse(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (dynamic_cast<const CLI::Success*>(&error)) throw;
    throw usage_error(app, error);
  }
}

// " (0123456789ab-dirty)"
std::string commit_text(const std::string& commit) {
  if (commit == "unknown") return "";
  const size_t dash = commit.find('-');
  return " (" + commit.substr(0, 12) + (dash == commit.npos ? "" : commit.substr(dash)) + ")";
}

// Reads the command line and runs the command.
int run(int argc, char** argv, const ProgramParts& parts, Call& call) {
  if (std::find(call.words.begin(), call.words.end(), "") != call.words.end()) {
    throw Error(ErrorCode::kUsage,
                "one of the command's words is empty; look for a variable that is not set");
  }
  CLI::App app{"Thew deforms the muscles and skin of animated characters.", "thew"};
  app.footer(kExitCodes);
  const std::string version = "thew " + std::string(kVersion) + commit_text(parts.commit);
  app.set_version_flag("--version", version);
  app.set_help_flag("--help,-h", "this help");
  app.add_flag_callback(
      "--man",
      [&] {
        const std::string name = fs::path(argv[0]).filename().string();
        throw CLI::CallForVersion(man_page(app, name, version), 0);
      },
      "the manual page, for man");
  app.add_option_function<std::string>(
      "--completion",
      [&](const std::string& shell) { throw CLI::CallForVersion(completion(app, shell), 0); },
      "what makes bash, zsh or fish complete words of the command");
  app.require_subcommand(1);
  CommandOptions options;
  app.add_flag("--json", options.json, kJsonFlag);
  options.command = command_text(argc, argv);
  std::error_code nowhere;
  options.directory = fs::current_path(nowhere).string();
  options.commit = parts.commit;
  parts.declare(app, options);
  try {
    parse(app, argc, argv);
  } catch (const CLI::Success& request) {  // --help, --version
    std::ostringstream text;
    app.exit(request, text, text);
    print(text.str());
    return 0;
  }
  call.command = command_of(app);
  call.json = options.json;
  call.out = options.out;
  if (options.json && options.progress == "openjd") {
    throw Error(ErrorCode::kUsage,
                "--progress openjd writes to standard output, where --json is to be alone; "
                "leave one of them out");
  }
  return static_cast<int>(parts.run(options, call));
}

// An error of the operating system as ours: whose fault it is and what to do about it. `otherwise`
// is the code where the number alone does not tell.
Error system_error(const std::error_code& cause, const std::string& subject, ErrorCode otherwise) {
  const int number = cause.value();
  const std::string what = subject + cause.message();
  if (number == EAGAIN || number == ENOMEM || number == EMFILE || number == ENFILE) {
    return {ErrorCode::kRetry,
            what + "; allow more processes, open files or memory (ulimit -a) and run again"};
  }
  if (number == ENOSPC || number == EDQUOT || number == EROFS) {
    return {ErrorCode::kOutput, what + "; free some space or write elsewhere"};
  }
  return {otherwise, what + "; check the path and its permissions"};
}

bool is_at_or_below(const fs::path& path, const fs::path& folder) {
  return !folder.empty() && (path == folder || is_below(path, folder));
}

Error defect(const std::exception& error) {
  return {ErrorCode::kSolver,
          std::string(error.what()) + "; this is a defect of Thew, please report it"};
}

// The exception that is being handled, as an Error.
Error current_error(const Call& call) {
  try {
    throw;
  } catch (const Error& error) {
    return error;
  } catch (const fs::filesystem_error& error) {
    const bool ours = is_at_or_below(error.path1(), call.out);
    return system_error(error.code(), error.path1().string() + ": ",
                        ours ? ErrorCode::kOutput : ErrorCode::kInput);
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::resource_unavailable_try_again) return defect(error);
    return system_error(error.code(), "a thread cannot be started: ", ErrorCode::kRetry);
  } catch (const std::bad_alloc&) {
    return {ErrorCode::kRetry, kNoMemory};
  } catch (const std::exception& error) {
    return defect(error);
  }
}

// The libraries know no options: where the advice at the end of a message is one that an option of
// the command follows, it is put in its words.
std::string with_options(std::string message, const std::string& command) {
  struct Advice {
    std::string_view of_library, of_command;
  };
  static constexpr Advice kAdvice[] = {
      {"or replace it", "or replace it with --overwrite"},
      {"replace them, or bake into another folder",
       "bake anew with --overwrite, or give another --out"},
      {"bake again from the start", "bake again without --resume"}};
  if (command == "bake" && message.ends_with("run again")) return message + " with --resume";
  for (const auto& [of_library, of_command] : kAdvice) {
    if (!message.ends_with(of_library)) continue;
    return message.replace(message.size() - of_library.size(), of_library.size(), of_command);
  }
  return message;
}

// One message for people and, where it was asked for, one document for programs.
int fail(const Error& error, const Call& call) {
  const std::string message = with_options(error.what(), call.command);
  std::fprintf(stderr, "thew: %s\n", printable(message).c_str());
  try {
    if (call.json) print_json(error_as_json(error.code(), split_error(message, call.words)));
  } catch (const Error&) {  // standard output is closed; the message has been given
  }
  return static_cast<int>(exit_code_of(error.code()));
}

// The exit code, whatever happens: an error is reported here.
int run_and_report(int argc, char** argv, const ProgramParts& parts) {
  Call call;
  call.words.assign(argv, argv + argc);
  const auto end = std::find(call.words.begin(), call.words.end(), "--");
  call.json = std::find(call.words.begin(), end, "--json") != end;
  open_standard_streams();
  try {
    parts.begin(call, argv);
    listen_for_signals();  // from here on: another program would not hear of an earlier one
    return run(argc, argv, parts, call);
  } catch (...) {
    return fail(current_error(call), call);
  }
}

// Where memory does not even suffice to report an error.
int run_guarded(int argc, char** argv, const ProgramParts& parts) {
  try {
    return run_and_report(argc, argv, parts);
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "thew: %s\n", kNoMemory);
    return static_cast<int>(ExitCode::kRetry);
  }
}

}  // namespace

void add_overwrite(CLI::App& command, CommandOptions& options, const char* what) {
  command.add_flag("--overwrite", options.overwrite, what);
}

void add_json(CLI::App& command, CommandOptions& options) {
  command.add_flag("--json", options.json, kJsonFlag);
}

void add_progress(CLI::App& command, CommandOptions& options) {
  command.add_option("--progress", options.progress, kProgressWords);
}

void add_threads(CLI::App& command, CommandOptions& options, const char* what) {
  command.add_option("--threads", options.threads, what)->check(CLI::Range(0, 1024));
}

CLI::Option* add_option_repeated(CLI::App& command, const char* name,
                                 std::vector<std::string>& values, const char* what) {
  return command.add_option(name, values, what)->type_size(1)->allow_extra_args(false);
}

int program_main(int argc, char** argv, const ProgramParts& parts) {
  return on_large_stack([&] { return run_guarded(argc, argv, parts); });
}

}  // namespace thew::tools
