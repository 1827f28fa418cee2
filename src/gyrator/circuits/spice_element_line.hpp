#pragma once

#include "gyrator/circuits/spice_builder.hpp"

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// An element's line while it is read: its words and assignments, each taken once.
class SpiceElementLine {
 public:
  SpiceElementLine(const SpiceCard& card, SpiceInstance& instance, SpiceBuilder& builder);

  const SpiceCard& card() const { return card_; }
  SpiceInstance& instance() { return instance_; }
  SpiceBuilder& builder() { return builder_; }
  /// The element's full name, "x1.r2".
  const std::string& name() const { return name_; }

  bool has_word() const { return next_ < card_.words.size(); }
  /// The next word in lower case; not taken. Empty where none is left.
  std::string peek() const;
  /// Takes the next word. Throws bad_input where `what` is missing.
  const std::string& take_word(std::string_view what);
  NodeId take_node(std::string_view what);
  /// A number, or an expression in braces or quotes.
  double take_number(std::string_view what);

  /// Takes the value assigned to a name.
  std::optional<double> take_value(std::string_view name);
  /// The same where it may not be negative or, with `positive`, zero either.
  std::optional<double> take_part(std::string_view name, bool positive = false);
  void ignore(std::initializer_list<std::string_view> names);
  /// Throws bad_input for a word or an assignment that nobody took.
  void finish();

  [[noreturn]] void refuse(const std::string& reason) const;

  /// Adds an element "<name><suffix>". Inside a built-in, what touches a node of its own is a
  /// signal.
  void add(std::string_view suffix, NodeId positive, NodeId negative, const ElementLaw& law);
  SpiceElement make_element(std::string_view suffix, NodeId positive, NodeId negative,
                            const ElementLaw& law) const;
  NodeId add_inner_node(std::string_view suffix);

 private:
  bool is_inner(NodeId node) const;

  const SpiceCard& card_;
  SpiceInstance& instance_;
  SpiceBuilder& builder_;
  std::string name_;
  std::size_t next_ = 1;
  std::vector<std::string> known_;  ///< names that were asked for
  std::vector<std::string> taken_;
};

}  // namespace gyrator
