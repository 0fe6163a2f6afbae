#pragma once
#include <algorithm>
#include <impact/input/option_text.hpp>
#include <impact/scenario/scenario.hpp>

/// The option tables: a row is all that is said of one option. From it come reading, range check, `-help`,
/// reference page, echo, the class at a restart, and what the option demands of others and of the mesh.
namespace impact {

/// What an option row says of itself, in `-help` and in the reference page.
struct OptionNote {
  std::string about{};    ///< meaning, one phrase
  std::string unit{};     ///< SI unit of a quantity, "1" for a pure number, "" when it is no quantity
  std::string notation{}; ///< symbol and equation, of the paper or src/theory.md, as "E (52)-(53)"
  std::string fallback{}; ///< default as text, that of the struct unless it is said
};

/// One reason to refuse a run, or to tell that an option is without effect in it. `words` are empty while
/// there is none. In them `<>` stands for the beginning that all options of this id have, as `-contact_tip_`,
/// and `{name}` for the text of the row of that name;
/// `{material}` for the id of the first material.
template <class Struct> struct OptionRule {
  enum class Of {
    absence, ///< the option is not given: `-key: missing; words`
    value,   ///< it is: `-key "text": words`
    key,     ///< it is: `-key` and the words at once
    other,   ///< it is, and contradicts another option: the words alone
    idle     ///< it is, and changes nothing: told, with the words as the reason
  } of;
  std::function<std::string(const Struct&, const Scenario&)> words;
};

template <class Struct> struct OptionRow {
  using Of = typename OptionRule<Struct>::Of;

  std::string name; ///< full name, or the attribute behind -<class>_<id>_; no dash
  OptionNote note;
  Interval range;      ///< of numbers
  std::string allowed; ///< choices, kind of text; numbers: from `range`
  RestartKey restart = RestartKey::guarded;
  std::function<void(Struct&, const GivenOption&, const OptionContext&)> read;
  std::function<std::string(const Struct&)> text; ///< "" = absent, nothing to print
  std::vector<OptionRule<Struct>> rules{};
  /// Of an option that names groups: the dimension that they must have, 0 for any, by that of the mesh.
  std::function<int(const Struct&, int dim)> group_dimension{};
  /// Why the option, which is given, does not fit a mesh of this dimension; "" when it does.
  std::function<std::string(const Struct&, int dim)> misfit{};

  bool given(const Struct& target) const { return text(target) != text(Struct()); }

  OptionRow& otherwise(const std::string& fallback) {
    note.fallback = fallback;
    return *this;
  }
  OptionRow& required() { return otherwise("required"); }
  OptionRow& notation(const std::string& said) {
    note.notation = said;
    return *this;
  }

  /// The option must be given where `when` holds: a predicate of the struct, or of it and the Scenario.
  /// `words`: a text, or a function with the same arguments.
  template <class When, class Words> OptionRow& needed(When when, Words words) {
    return add(Of::absence, when, words);
  }
  /// The option must not be given, or not with its value, where `when` holds.
  template <class When, class Words> OptionRow& refused(When when, Words words) {
    return add(Of::value, when, words);
  }
  /// As `refused`, but the message goes on where the name of the option ends.
  template <class When, class Words> OptionRow& barred(When when, Words words) {
    return add(Of::key, when, words);
  }
  /// The option must not be given beside another one, which the words name.
  template <class When, class Words> OptionRow& denied(When when, Words words) {
    return add(Of::other, when, words);
  }

  /// The option changes nothing where `when` holds; the words go on after "because".
  template <class When, class Words> OptionRow& idle(When when, Words words) {
    return add(Of::idle, when, words);
  }

private:
  template <class Function> static auto ask(const Function& f, const Struct& target, const Scenario& all) {
    if constexpr (std::is_invocable_v<Function, const Struct&>)
      return f(target);
    else
      return f(target, all);
  }
  template <class When, class Words> OptionRow& add(Of of, When when, Words words) {
    rules.push_back({of, [=](const Struct& target, const Scenario& all) -> std::string {
                       if (!ask(when, target, all)) return "";
                       if constexpr (std::is_convertible_v<Words, std::string>)
                         return words;
                       else
                         return ask(words, target, all);
                     }});
    return *this;
  }
};

/// In the place of a unit that another option decides.
inline const std::string by_type = "by type";

/// Makes rows and adds them to a list. `part` leads from the struct to what holds the members (nothing: they
/// are its own).
template <class Struct, class Part = std::identity> class Rows {
public:
  using Row = OptionRow<Struct>;

  explicit Rows(std::vector<OptionRow<Struct>>& list, RestartKey restart_class = RestartKey::guarded,
                Part part = {})
      : restart(restart_class), list_(list), part_(part) {}

  RestartKey restart; ///< of the rows from here on

  /// Of all rows: `name` and `place` of the option, and what it is `about`. `quantity`: SI unit, symbol and
  /// equation, as in "Pa E (52)-(53)".
  Row& number(const std::string& name, auto place, const std::string& quantity, const AllowedNumbers& allowed,
              const std::string& about) {
    const double fallback = at(place)(std::as_const(example_));
    return add(name, place, number_kind(unit_of(quantity), allowed, fallback), about, quantity);
  }
  Row& count(const std::string& name, auto place, int low, const std::string& about,
             int high = std::numeric_limits<int>::max()) {
    return add(name, place, count_kind(low, high, at(place)(std::as_const(example_))), about);
  }
  Row& flag(const std::string& name, auto place, const std::string& about) {
    return add(name, place, flag_kind(), about);
  }
  Row& text(const std::string& name, auto place, const std::string& allowed, const std::string& about) {
    return add(name, place, text_kind(allowed), about);
  }
  Row& file(const std::string& name, auto place, const std::string& about) {
    return add(name, place, file_kind(), about);
  }
  template <class Value> using Choices = std::vector<std::pair<std::string, Value>>;
  template <class Value, class Sub>
  Row& choice(const std::string& name, Value Sub::*place, const std::string& about,
              const std::type_identity_t<Choices<Value>>& choices) {
    return add(name, place, choice_kind(choices), about);
  }
  /// The choices one after the other: word, value, word, value, ..
  template <class Value, class Sub, class... Rest>
  Row& choice(const std::string& name, Value Sub::*place, const std::string& about, const char* word,
              const Rest&... rest) {
    Choices<Value> choices;
    add_choices(choices, word, rest...);
    return choice(name, place, about, choices);
  }
  Row& list(const std::string& name, auto place, const std::string& about,
            const std::vector<std::string>& choices = {}) {
    return add(name, place, list_kind(choices, true), about);
  }
  /// Groups of the mesh, required; `dimension` as OptionRow::group_dimension.
  Row& groups(const std::string& name, auto place, const std::string& about,
              const std::function<int(const Struct&, int dim)>& dimension) {
    Row& row = add(name, place, list_kind({}, false), about).required();
    row.group_dimension = dimension;
    return row;
  }
  Row& numbers(const std::string& name, auto place, const std::string& quantity, const Interval& range,
               const std::string& about) {
    return add(name, place, numbers_kind(unit_of(quantity), range), about, quantity);
  }
  Row& point(const std::string& name, auto place, const std::string& quantity, const std::string& about) {
    return add(name, place, point_kind(unit_of(quantity)), about, quantity);
  }

  using UnitOf = std::function<std::string(const Struct&)>;
  /// An expression. Where what has been read before decides its unit and range, `unit` and `range_of` find
  /// them, and `quantity` and `range` are what the reference says.
  Row& expression(const std::string& name, auto place, const std::string& quantity, const Interval& range,
                  const std::string& about, const UnitOf& unit = {},
                  const std::function<Interval(const Struct&)>& range_of = {}) {
    const auto text = [](const std::optional<Expression>& value) { return value ? value->text() : ""; };
    Row& row = add(name, place, OptionKind<std::optional<Expression>>{"expression", range, {}, text}, about,
                   quantity);
    row.read = [=, at = at(place), own = row.note.unit](Struct& target, const GivenOption& option,
                                                        const OptionContext& context) {
      at(target) =
          read_expression(option, unit ? unit(target) : own, context, range_of ? range_of(target) : range);
    };
    return row;
  }

  /// Rows `<stem>x`, `<stem>y`, `<stem>z` of an array of three expressions; a plane mesh takes those in the
  /// plane, or of rotations the one about z.
  enum class Of { places, turns };
  void components(const std::string& stem, auto place, const std::string& quantity, const std::string& about,
                  Of of = Of::places, const UnitOf& unit = {}) {
    for (int k = 0; k < 3; ++k) {
      Row& row = expression(
          stem + "xyz"[k], [=](auto& target) -> auto& { return (target.*place)[k]; }, quantity, any_number,
          about, unit);
      if (of == Of::places ? k == 2 : k < 2)
        row.misfit = [=](const Struct&, int dim) {
          return dim == 3 ? std::string()
                          : std::string("the mesh is plane; allowed: ") +
                                (of == Of::turns ? "rz" : "x and y components");
        };
    }
  }

private:
  template <class Place> auto at(Place place) const {
    return [ part = part_, place ](auto& target) -> auto& {
      return std::invoke(place, std::invoke(part, target));
    };
  }

  static std::string unit_of(const std::string& quantity) {
    return quantity == by_type ? quantity : quantity.substr(0, quantity.find(' '));
  }

  // Points are plain arrays where they are kept.
  template <class Value> static void assign(Value& place, Value value) { place = std::move(value); }
  static void assign(double (&place)[3], const std::array<double, 3>& value) {
    std::copy(value.begin(), value.end(), place);
  }
  template <class Value> static const Value& plain(const Value& value) { return value; }
  static std::array<double, 3> plain(const double (&value)[3]) { return std::to_array(value); }

  template <class Value, class... Rest>
  static void add_choices(Choices<Value>& choices, const char* word, const std::type_identity_t<Value>& value,
                          const Rest&... rest) {
    choices.emplace_back(word, value);
    if constexpr (sizeof...(rest) > 0) add_choices(choices, rest...);
  }

  template <class Place, class Value>
  Row& add(const std::string& name, Place place, const OptionKind<Value>& kind, const std::string& about,
           const std::string& quantity = "") {
    Row& row = list_.emplace_back();
    row.name = name;
    row.range = kind.range;
    row.allowed = kind.allowed;
    row.restart = restart;
    row.note.about = about;
    row.note.unit = unit_of(quantity);
    if (quantity != row.note.unit) row.notation(quantity.substr(row.note.unit.size() + 1));
    row.read = [at = at(place), read = kind.read](Struct& target, const GivenOption& option,
                                                  const OptionContext& context) {
      assign(at(target), read(option, context));
    };
    row.text = [at = at(place), get = kind.text](const Struct& target) { return get(plain(at(target))); };
    return row.otherwise(row.text(example_));
  }

  std::vector<Row>& list_;
  Part part_;
  Struct example_; ///< whose values are the defaults
};

} // namespace impact
