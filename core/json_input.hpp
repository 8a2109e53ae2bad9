// JSON text with places: a strict parser and a cursor that knows its JSON pointer. Everything that is
// refused throws ModelError with the source, the pointer, the offending value and what is allowed.
#pragma once

#include "core/model.hpp"
#include "core/words.hpp"

#include <nlohmann/json.hpp>

#include <initializer_list>
#include <map>
#include <string>
#include <string_view>

namespace gudgeon {

/// Parses strictly: repeated keys, numbers beyond double, NaN and Infinity are refused at their
/// pointer; text that is no JSON with pointer "", line and column. Objects keep the order of the file.
nlohmann::ordered_json parse_json(std::string_view text, const std::string& source);

/// One value of a model file. Numbers may be given by the name of a parameter.
class JsonInput {
  public:
    struct Context {
        std::string source;
        std::map<std::string, double> parameters;
    };

    JsonInput(const nlohmann::ordered_json& value, std::string pointer, const Context& context)
        : value_(&value), pointer_(std::move(pointer)), context_(&context) {}

    // Objects
    /// Refuses a value that is no object, and keys that are not in the list.
    void expect_keys(std::initializer_list<const char*> known) const;
    bool has(const char* key) const { return value_->contains(key); }
    JsonInput at(const char* key) const; // refused if missing
    double number(const char* key, double otherwise) const;
    std::vector<std::pair<std::string, JsonInput>> members() const;

    // Arrays
    std::vector<JsonInput> items() const;
    std::vector<JsonInput> items(std::size_t count, const char* what) const;

    // Values
    double number() const;
    /// A number written as such: no parameter name.
    double literal() const;
    std::string text() const;
    bool flag() const;
    Vec3 vector() const;
    std::vector<double> numbers() const;
    /// A string out of a list; returns its place in the list.
    std::size_t choice(std::initializer_list<const char*> allowed) const;

    bool is_object() const { return value_->is_object(); }
    bool is_array() const { return value_->is_array(); }
    std::size_t size() const { return value_->size(); }
    const std::string& pointer() const { return pointer_; }
    /// The value as text, shortened.
    std::string shown() const;
    [[noreturn]] void refuse(const std::string& problem, const std::string& allowed) const;

  private:
    JsonInput child(const std::string& key, const nlohmann::ordered_json& value) const;

    const nlohmann::ordered_json* value_;
    std::string pointer_;
    const Context* context_;
};

} // namespace gudgeon
