#include "core/json_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <unordered_set>

namespace gudgeon {

using Json = nlohmann::ordered_json;

namespace {

std::string escaped(const std::string& key) {
    std::string out;
    for (const char c : key) {
        if (c == '~')
            out += "~0";
        else if (c == '/')
            out += "~1";
        else
            out += c;
    }
    return out;
}

std::string clipped(std::string text, std::size_t longest = 60) {
    if (text.size() > longest) {
        // Not inside a UTF-8 character.
        std::size_t cut = longest;
        while (cut > 0 && (static_cast<unsigned char>(text[cut]) & 0xC0) == 0x80)
            --cut;
        text = text.substr(0, cut) + "...";
    }
    return text;
}

std::string dumped(const Json& value) {
    return clipped(value.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// Builds the document from parser events and knows the pointer of the value that comes next.
class Builder final : public nlohmann::json_sax<Json> {
  public:
    Builder(std::string_view text, const std::string& source) : text_(text), source_(source) {}

    Json take() { return std::move(root_); }

    bool null() override { return put(nullptr); }
    bool boolean(bool value) override { return put(value); }
    bool number_integer(number_integer_t value) override { return put(value); }
    bool number_unsigned(number_unsigned_t value) override { return put(value); }
    bool number_float(number_float_t value, const string_t&) override { return put(value); }
    bool string(string_t& value) override { return put(std::move(value)); }
    bool binary(binary_t&) override { return false; } // not part of JSON text
    bool start_object(std::size_t) override { return open(Json::object()); }
    bool start_array(std::size_t) override { return open(Json::array()); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }

    bool key(string_t& name) override {
        Level& level = levels_.back();
        level.key = name;
        if (is_repeated(level, name))
            throw ModelError(source_, pointer(), fmt::format("the key '{}' is repeated", clipped(name)),
                             "each key once");
        return true;
    }

    bool parse_error(std::size_t position, const std::string& token,
                     const nlohmann::json::exception& error) override {
        if (error.id == 406)
            throw ModelError(source_, pointer(),
                             fmt::format("{} is beyond the range of a number", clipped(token)),
                             "magnitudes below 1.8e308");
        if (const std::string name = non_number(position); !name.empty())
            throw ModelError(source_, pointer(), fmt::format("{} is no number of JSON", name),
                             "finite numbers");
        throw ModelError(source_, "", not_json(position), "a model in JSON");
    }

  private:
    struct Level {
        Json value;
        std::string key;
        std::unordered_set<std::string> keys; // of an object with many
    };
    static constexpr std::size_t deepest = 64;

    /// A search through few keys is quicker than a table of them.
    static bool is_repeated(Level& level, const std::string& name) {
        constexpr std::size_t few = 16;
        const auto& members = level.value.get_ref<const Json::object_t&>();
        if (members.size() < few)
            return std::ranges::any_of(members, [&](const auto& member) { return member.first == name; });
        if (level.keys.empty())
            for (const auto& [key, value] : members)
                level.keys.insert(key);
        return !level.keys.insert(name).second;
    }

    bool put(Json value) {
        if (levels_.empty())
            root_ = std::move(value);
        else if (levels_.back().value.is_array())
            levels_.back().value.push_back(std::move(value));
        else // the key is new: append without a search
            levels_.back().value.get_ref<Json::object_t&>().emplace_back(levels_.back().key,
                                                                         std::move(value));
        return true;
    }

    bool open(Json value) {
        if (levels_.size() >= deepest)
            throw ModelError(source_, "", fmt::format("nested deeper than {} levels", deepest),
                             "a model in JSON");
        levels_.push_back({std::move(value), {}, {}});
        return true;
    }

    bool close() {
        Json value = std::move(levels_.back().value);
        levels_.pop_back();
        return put(std::move(value));
    }

    std::string pointer() const {
        std::string out;
        for (const Level& level : levels_)
            out += '/' + (level.value.is_array() ? std::to_string(level.value.size()) : escaped(level.key));
        return out;
    }

    /// The word at the position if it is one of the numbers that JSON does not have.
    std::string non_number(std::size_t position) const {
        std::size_t first = std::min(position, text_.size());
        while (first > 0 && in_word(text_[first - 1]))
            --first;
        std::size_t last = first;
        while (last < text_.size() && in_word(text_[last]))
            ++last;
        const std::string word(text_.substr(first, last - first));
        std::string bare;
        for (const char c : word)
            if (std::isalpha(static_cast<unsigned char>(c)))
                bare += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        return bare == "nan" || bare == "inf" || bare == "infinity" ? word : "";
    }

    std::string not_json(std::size_t position) const {
        if (std::ranges::all_of(text_, [](char c) { return std::isspace(static_cast<unsigned char>(c)); }))
            return "no JSON: the text is empty";
        const std::string_view read = text_.substr(0, std::min(position, text_.size()));
        const std::size_t end = fault(read);
        const auto before = read.substr(0, end);
        const auto line = 1 + std::ranges::count(before, '\n');
        const std::size_t start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
        if (position > text_.size())
            return fmt::format("no JSON: the text ends too early, at line {}, column {}", line,
                               end - start + 2);
        return fmt::format("no JSON at line {}, column {}: '{}'", line, end - start + 1, excerpt(end));
    }

    /// Start of the word or string that the parser read last.
    static std::size_t fault(std::string_view read) {
        if (read.empty())
            return 0;
        std::size_t start = read.size() - 1;
        if (read[start] == '"') {
            const std::size_t open = start == 0 ? start : read.rfind('"', start - 1);
            return open == std::string_view::npos ? start : open;
        }
        while (start > 0 && in_word(read[start]) && in_word(read[start - 1]))
            --start;
        return start;
    }

    static bool in_word(char c) {
        return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '+';
    }

    /// The rest of the line, made printable.
    std::string excerpt(std::size_t from) const {
        std::string out(text_.substr(from, 20));
        out.resize(std::min(out.size(), out.find_first_of("\r\n")));
        for (char& c : out)
            if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126)
                c = '?';
        return out;
    }

    std::string_view text_;
    const std::string& source_;
    Json root_;
    std::vector<Level> levels_;
};

} // namespace

Json parse_json(std::string_view text, const std::string& source) {
    Builder builder(text, source);
    Json::sax_parse(text.begin(), text.end(), &builder);
    return builder.take();
}

void JsonInput::refuse(const std::string& problem, const std::string& allowed) const {
    throw ModelError(context_->source, pointer_, problem, allowed);
}

std::string JsonInput::shown() const { return dumped(*value_); }

JsonInput JsonInput::child(const std::string& key, const Json& value) const {
    return {value, pointer_ + '/' + escaped(key), *context_};
}

void JsonInput::expect_keys(std::initializer_list<const char*> known) const {
    const std::vector<std::string> names(known.begin(), known.end());
    for (const auto& [key, member] : members()) {
        if (std::ranges::find(names, key) != names.end())
            continue;
        member.refuse(fmt::format("unknown key '{}'", clipped(key)), suggestion(key, names) + listed(names));
    }
}

JsonInput JsonInput::at(const char* key) const {
    if (!has(key))
        throw ModelError(context_->source, pointer_ + '/' + key, fmt::format("'{}' is missing", key),
                         fmt::format("'{}' is required here", key));
    return child(key, value_->at(key));
}

double JsonInput::number(const char* key, double otherwise) const {
    return has(key) ? at(key).number() : otherwise;
}

std::vector<std::pair<std::string, JsonInput>> JsonInput::members() const {
    if (!value_->is_object())
        refuse(fmt::format("{} is no object", shown()), "an object {...}");
    std::vector<std::pair<std::string, JsonInput>> out;
    for (const auto& [key, value] : value_->items())
        out.emplace_back(key, child(key, value));
    return out;
}

std::vector<JsonInput> JsonInput::items() const {
    if (!value_->is_array())
        refuse(fmt::format("{} is no array", shown()), "an array [...]");
    std::vector<JsonInput> out;
    out.reserve(value_->size());
    for (std::size_t i = 0; i < value_->size(); ++i)
        out.push_back(child(std::to_string(i), (*value_)[i]));
    return out;
}

std::vector<JsonInput> JsonInput::items(std::size_t count, const char* what) const {
    if (!value_->is_array() || value_->size() != count)
        refuse(fmt::format("{} is no array of {}", shown(), count), fmt::format("{} {}", count, what));
    return items();
}

double JsonInput::literal() const {
    if (!value_->is_number())
        refuse(fmt::format("{} is no number", shown()), "a number");
    return value_->get<double>();
}

double JsonInput::number() const {
    if (!value_->is_string())
        return value_->is_number()
                   ? value_->get<double>()
                   : (refuse(fmt::format("{} is no number", shown()), "a number or the name of a parameter"),
                      0.0);
    const auto& name = value_->get_ref<const std::string&>();
    const auto found = context_->parameters.find(name);
    if (found == context_->parameters.end()) {
        std::vector<std::string> names;
        for (const auto& entry : context_->parameters)
            names.push_back(entry.first);
        refuse(fmt::format("unknown parameter {}", shown()),
               fmt::format("{}a number or a parameter of the file ({})", suggestion(name, names),
                           listed(names)));
    }
    return found->second;
}

std::string JsonInput::text() const {
    if (!value_->is_string())
        refuse(fmt::format("{} is no string", shown()), "a string");
    return value_->get<std::string>();
}

bool JsonInput::flag() const {
    if (!value_->is_boolean())
        refuse(fmt::format("{} is neither true nor false", shown()), "true, false");
    return value_->get<bool>();
}

Vec3 JsonInput::vector() const {
    const auto parts = items(3, "numbers");
    return {parts[0].number(), parts[1].number(), parts[2].number()};
}

std::vector<double> JsonInput::numbers() const {
    std::vector<double> out;
    for (const JsonInput& item : items())
        out.push_back(item.number());
    return out;
}

std::size_t JsonInput::choice(std::initializer_list<const char*> allowed) const {
    const std::vector<std::string> names(allowed.begin(), allowed.end());
    if (!value_->is_string())
        refuse(fmt::format("{} is no string", shown()), listed(names));
    const auto& word = value_->get_ref<const std::string&>();
    const auto found = std::ranges::find(names, word);
    if (found == names.end())
        refuse(fmt::format("unknown value {}", shown()), suggestion(word, names) + listed(names));
    return static_cast<std::size_t>(found - names.begin());
}

} // namespace gudgeon
