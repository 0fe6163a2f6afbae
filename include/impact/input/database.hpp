#pragma once
#include <optional>
#include <petscsys.h>
#include <string>
#include <vector>

/// PETSc's options database as we read it: every value as text, so that a wrong one gets our message.
namespace impact {

/// One option as the user gave it; `key` has its dash.
struct GivenOption {
  std::string key, text;
};

/// Throws UserError(usage): `-key "text": reason`.
[[noreturn]] void refuse_option(const GivenOption& option, const std::string& reason);

/// Names (without dash, spelled as typed) of all options in the database. A blank-separated word of a value
/// that begins with a dash is listed too; option_text tells it from an option.
std::vector<std::string> option_names();

/// Text of the option `name` (no dash, any case) without blanks around it, "" for an option without a value,
/// empty when it was not given. Marks it as used for PETSc.
std::optional<std::string> option_text(const std::string& name);

/// Sets the text that PETSc's own readers of `name` will see.
void replace_option(const std::string& name, const std::string& text);

/// Folders of the options files named on the command line, each before those that it names, then the working
/// directory "".
std::vector<std::string> option_folders();

/// Path of an existing file: absolute, or below the first of option_folders() that has it. Collective; rank 0
/// looks. Throws UserError(io) naming the folders.
std::string find_input_file(MPI_Comm comm, const GivenOption& option);

/// Some editors put it before a text; no reader of ours or of PETSc's takes it for a blank.
inline constexpr const char* byte_order_mark = "\xEF\xBB\xBF";

/// Follows the options files of a command line (and of PETSC_OPTIONS) and those that they name, before PETSc
/// reads them: one that leads back to itself has no end, and PETSc runs out of memory for its calls. Throws
/// UserError(usage) for it, for one that begins with a byte-order mark, for a word of the command line that
/// belongs to no option, which PETSc passes over, and for an option that one file gives twice: PETSc takes
/// the last one in silence. Later files and the command line may override it. Each rank reads by itself: MPI
/// has not started.
void check_option_files(int argc, const char* const* argv);
/// Why PETSc could not read the options of a command line, with the line of a YAML file.
std::string explain_unread_files(int argc, const char* const* argv, const std::string& petsc_message);

/// Whether the option `name` (no dash, any case) stands on the command line itself.
bool on_command_line(const std::string& name);

/// What the options files of the command line, and those that they name, say of an option, whether or not
/// another word came later.
std::vector<std::string> texts_in_files(const std::string& name);

/// Whole text of a file without its byte-order mark, read on rank 0. Collective. Throws UserError(io).
std::string read_input_file(MPI_Comm comm, const GivenOption& option, const std::string& path);

/// Read by PETSc in PetscInitialize or only in PetscFinalize (-log_view, ...), so that "unread" says nothing.
bool read_at_the_ends(const std::string& name);

/// Options that nobody has read so far, without those that are read at the ends.
std::vector<GivenOption> unread_options();

} // namespace impact
