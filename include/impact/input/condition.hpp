#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

/// A comparison of named numbers, as in `force < 0.1*peak(force) and t > 1` (muParser): what a run may be
/// stopped by.
namespace impact {

class Condition {
public:
  using Value = std::function<double(const std::string& name)>;
  struct Peak {
    std::string text;
    double value;
    std::function<double(const Value&)> argument;
  };

  /// Parses `text`; `key` names the option in messages. Names that are no parameter and nothing of the
  /// language of Expression are looked up when it is evaluated. Throws UserError(usage) for what is no
  /// expression.
  Condition(std::string key, std::string text,
            const std::vector<std::pair<std::string, double>>& parameters = {});

  const std::string& key() const { return key_; }
  const std::string& text() const { return text_; }
  /// The names that are looked up, each once.
  const std::vector<std::string>& names() const { return names_; }
  /// What stands in peak(), in order, with its largest value since it was first noted, not a number before.
  std::vector<Peak>& peaks() { return peaks_; }

  /// Raises the peaks with the present values; a value that is not a number leaves them as they are.
  void note(const Value& value);
  /// Whether it holds for the present values and peaks. A comparison with what is not a number never holds.
  bool holds(const Value& value) const;

private:
  std::string take_peaks();
  std::function<double(const Value&)> compile(const std::string& expression,
                                              const std::vector<std::pair<std::string, double>>& parameters);

  std::string key_, text_;
  std::vector<std::string> names_;
  std::vector<Peak> peaks_;
  std::function<double(const Value&)> whole_; ///< in which the peaks have names of their own
};

} // namespace impact
