// SPDX-License-Identifier: Apache-2.0
// sinew completion, sinew man: scripts for shells and pages for man, made of what the commands themselves declare.
#include <cstdio>
#include <memory>
#include <sstream>

#include "apps/app.h"
#include "sim/input_error.h"
#include "sim/manifest.h"

namespace sinew::apps {
namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& program) {
  return program.get_subcommands([](const CLI::App*) { return true; });
}

// An option, in the parts that shells and pages are made of.
struct Described {
  std::vector<std::string> flags;    // "--out"; empty: an argument by its place
  std::string name;                  // of the argument
  std::string words;                 // what it is, in a line
  std::vector<std::string> choices;  // where it is one of these
  bool takes_value, required;
};

std::vector<Described> options_of(const CLI::App& command) {
  std::vector<Described> result;
  for (const CLI::Option* option : command.get_options()) {
    Described one;
    for (const std::string& name : option->get_snames()) one.flags.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) one.flags.push_back("--" + name);
    one.name = option->get_single_name();
    one.words = option->get_description();
    one.takes_value = option->get_items_expected_max() > 0;
    one.required = option->get_required();
    // CLI11 tells a choice as the name of its type: "TEXT:{published,stateful}".
    const std::string type = option->get_type_name();
    const std::size_t open = type.find('{'), close = type.find('}');
    if (open != std::string::npos && close != std::string::npos) {
      std::istringstream among(type.substr(open + 1, close - open - 1));
      for (std::string choice; std::getline(among, choice, ',');) one.choices.push_back(choice);
    }
    result.push_back(one);
  }
  return result;
}

std::string joined_words(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

// Within single quotes of a shell.
std::string quoted(const std::string& text, const char* quote_inside) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string(quote_inside) : std::string(1, c);
  return result + "'";
}

std::string bash_script(const CLI::App& program) {
  std::string commands, cases;
  for (const CLI::App* command : commands_of(program)) {
    commands += (commands.empty() ? "" : " ") + command->get_name();
    std::string flags, values;
    for (const Described& option : options_of(*command)) {
      flags += (flags.empty() ? "" : " ") + joined_words(option.flags);
      if (option.choices.empty()) continue;
      if (option.flags.empty()) values += "      \"\") choices='" + joined_words(option.choices) + "' ;;\n";
      for (const std::string& flag : option.flags) values += "      " + flag + ") choices='" + joined_words(option.choices) + "' ;;\n";
    }
    cases += "    " + command->get_name() + ")\n      options='" + flags + "'\n";
    if (!values.empty()) cases += "      case $before in\n" + values + "      esac\n";
    cases += "      ;;\n";
  }
  return "# bash completion for sinew, made by `sinew completion bash`\n"
         "_sinew() {\n"
         "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} options='' choices=''\n"
         "  COMPREPLY=()\n"
         "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
         "    mapfile -t COMPREPLY < <(compgen -W '" +
         commands +
         " --help --version' -- \"$word\")\n"
         "    return\n"
         "  fi\n"
         "  [ \"$COMP_CWORD\" -eq 2 ] && before=''\n"
         "  case ${COMP_WORDS[1]} in\n" +
         cases +
         "  esac\n"
         "  if [[ $word == -* ]]; then mapfile -t COMPREPLY < <(compgen -W \"$options\" -- \"$word\")\n"
         "  elif [ -n \"$choices\" ]; then mapfile -t COMPREPLY < <(compgen -W \"$choices\" -- \"$word\")\n"
         "  fi  # anything else: a file, as `-o default` says\n"
         "}\n"
         "complete -o default -F _sinew sinew\n";
}

std::string zsh_script(const CLI::App& program) {
  // _arguments takes colons and brackets for its own.
  const auto plain = [](const std::string& text) {
    std::string result;
    for (const char c : text) {
      if (c == ':' || c == '[' || c == ']' || c == '\\') result += '\\';
      result += c;
    }
    return result;
  };
  const auto single = [&](const std::string& text) { return quoted(text, "'\\''"); };
  std::string commands, cases;
  for (const CLI::App* command : commands_of(program)) {
    commands += "    " + single(plain(command->get_name()) + ":" + plain(command->get_description())) + "\n";
    cases += "    " + command->get_name() + ")\n      _arguments";
    for (const Described& option : options_of(*command)) {
      const std::string action = option.choices.empty() ? "_files" : "(" + joined_words(option.choices) + ")";
      const std::string value = ":" + plain(option.name) + ":" + action;
      if (option.flags.empty()) cases += " \\\n        " + single("*" + value);
      for (const std::string& flag : option.flags)
        cases += " \\\n        " + single("*" + flag + "[" + plain(option.words) + "]" + (option.takes_value ? value : ""));
    }
    cases += "\n      ;;\n";
  }
  return "#compdef sinew\n"
         "# zsh completion for sinew, made by `sinew completion zsh`\n"
         "_sinew() {\n"
         "  local -a commands\n"
         "  commands=(\n" +
         commands +
         "  )\n"
         "  if (( CURRENT == 2 )); then\n"
         "    _describe command commands\n"
         "    return\n"
         "  fi\n"
         "  local command=$words[2]\n"
         "  shift words\n"
         "  (( CURRENT-- ))\n"
         "  case $command in\n" +
         cases +
         "  esac\n"
         "}\n"
         "if [ \"$funcstack[1]\" = _sinew ]; then _sinew \"$@\"; else compdef _sinew sinew; fi\n";
}

std::string fish_script(const CLI::App& program) {
  const auto single = [](const std::string& text) { return quoted(text, "\\'"); };
  std::string text = "# fish completion for sinew, made by `sinew completion fish`\n";
  for (const CLI::App* command : commands_of(program)) {
    text += "complete -c sinew -n __fish_use_subcommand -f -a " + command->get_name() + " -d " + single(command->get_description()) + "\n";
    const std::string of = "complete -c sinew -n '__fish_seen_subcommand_from " + command->get_name() + "'";
    for (const Described& option : options_of(*command)) {
      if (option.flags.empty() && !option.choices.empty()) text += of + " -f -a " + single(joined_words(option.choices)) + "\n";
      if (option.flags.empty()) continue;
      text += of;
      for (const std::string& flag : option.flags) text += flag.starts_with("--") ? " -l " + flag.substr(2) : " -s " + flag.substr(1);
      if (option.takes_value) text += " -r";
      if (!option.choices.empty()) text += " -f -a " + single(joined_words(option.choices));
      text += " -d " + single(option.words) + "\n";
    }
  }
  return text;
}

// Text of a page: backslashes, hyphens and a line's first dot or quote are troff's own.
std::string roff(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (result.empty() ? c == '.' || c == '\'' : result.back() == '\n' && (c == '.' || c == '\'')) result += "\\&";
    result += c == '\\' ? std::string("\\e") : c == '-' ? std::string("\\-") : std::string(1, c);
  }
  return result;
}

std::string page_head(const std::string& title, const std::string& words) {
  std::string upper;
  for (const char c : title) upper += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return ".TH " + roff(upper) + " 1 \"\" \"sinew " + sim::this_build().version + "\" \"sinew\"\n.SH NAME\n" + roff(title) + " \\- " +
         roff(words) + "\n";
}

std::string examples(const CLI::App& command) {
  const std::string footer = command.get_footer();
  if (footer.empty()) return "";
  const std::size_t first = footer.find('\n');  // "Examples:"
  return ".SH EXAMPLES\n.nf\n" + roff(first == std::string::npos ? footer : footer.substr(first + 1)) + "\n.fi\n";
}

std::string page_of(const CLI::App& command) {
  std::string synopsis = ".B sinew " + roff(command.get_name()) + "\n", options;
  for (const Described& option : options_of(command)) {
    if (option.flags.empty()) {
      synopsis += ".I " + roff(option.required ? option.name : "[" + option.name + "]") + "\n";
      options += ".TP\n.I " + roff(option.name) + "\n";
    } else {
      std::string names;
      for (const std::string& flag : option.flags) names += (names.empty() ? "\\fB" : ", \\fB") + roff(flag) + "\\fR";
      const std::string value = option.takes_value ? " \\fI" + std::string(option.choices.empty() ? "value" : "choice") + "\\fR" : "";
      if (option.required) synopsis += names + value + "\n";
      options += ".TP\n" + names + value + "\n";
    }
    options += roff(option.words);
    if (!option.choices.empty()) options += roff(" (" + joined_words(option.choices) + ")");
    options += "\n";
  }
  return page_head("sinew-" + command.get_name(), command.get_description()) + ".SH SYNOPSIS\n" + synopsis +
         "[\\fIoption\\fR ...]\n.SH OPTIONS\n" + options + examples(command) +
         ".SH EXIT STATUS\n0: done. 1: it could not be done. 2: an argument or a file is wrong. 130: interrupted.\n.SH SEE ALSO\n.BR sinew "
         "(1)\n";
}

std::string page_of_program(const CLI::App& program) {
  std::string list, see;
  for (const CLI::App* command : commands_of(program)) {
    list += ".TP\n.B " + roff(command->get_name()) + "\n" + roff(command->get_description()) + "\n";
    see += (see.empty() ? ".BR sinew\\-" : " (1),\n.BR sinew\\-") + roff(command->get_name());
  }
  return page_head("sinew", program.get_description()) + ".SH SYNOPSIS\n.B sinew\n\\fIcommand\\fR [\\fIoption\\fR ...]\n.SH COMMANDS\n" +
         list + examples(program) + ".SH SEE ALSO\n" + see + " (1)\n";
}

}  // namespace

void add_completion(CLI::App& program, int& exit_code) {
  auto shell = std::make_shared<std::string>();
  CLI::App* command = program.add_subcommand("completion", "Print a script with which a shell completes commands and options.");
  command->add_option("shell", *shell, "bash, zsh or fish")->required()->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command->footer("Examples:\n  source <(sinew completion bash)\n  sinew completion fish > ~/.config/fish/completions/sinew.fish");
  command->callback([shell, &program, &exit_code] {
    const std::string script = *shell == "bash" ? bash_script(program) : *shell == "zsh" ? zsh_script(program) : fish_script(program);
    std::fputs(script.c_str(), stdout);
    exit_code = 0;
  });
}

void add_man(CLI::App& program, int& exit_code) {
  auto name = std::make_shared<std::string>();
  CLI::App* command = program.add_subcommand("man", "Print the manual page of a command, or of sinew itself.");
  command->add_option("command", *name, "left out: sinew itself");
  command->footer("Examples:\n  sinew man diagnose | man -l -\n  sinew man > sinew.1");
  command->callback([name, &program, &exit_code] {
    exit_code = 0;
    if (name->empty()) {
      std::fputs(page_of_program(program).c_str(), stdout);
      return;
    }
    std::vector<std::string> names;
    for (const CLI::App* one : commands_of(program)) {
      names.push_back(one->get_name());
      if (one->get_name() == *name) {
        std::fputs(page_of(*one).c_str(), stdout);
        return;
      }
    }
    throw sim::InputError({.file = "", .key = "command", .value = *name, .advice = "no such command" + sim::did_you_mean(*name, names)});
  });
}

}  // namespace sinew::apps
