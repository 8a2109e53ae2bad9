// The command run inside the test program, its streams and its files.
#pragma once

#include "app/command_line.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <unistd.h>

namespace gudgeon::test {

struct Outcome {
    int code;
    std::string out, err;
};

inline Outcome command(const std::vector<std::string>& args, bool terminal = false) {
    std::ostringstream out, err;
    const int code = command_line(args, {out, err, terminal});
    return {code, out.str(), err.str()};
}

inline std::string text_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

inline nlohmann::json summary_in(const std::filesystem::path& folder) {
    return nlohmann::json::parse(text_of(folder / "summary.json"));
}

struct Csv {
    std::vector<std::string> names;              // t first
    std::vector<std::vector<double>> rows;       // as the header
    std::vector<std::vector<std::string>> words; // the same as written
    std::size_t column(const std::string& name) const {
        for (std::size_t i = 0; i < names.size(); ++i)
            if (names[i] == name)
                return i;
        throw std::runtime_error("no column " + name);
    }
};

inline Csv read_csv(const std::filesystem::path& file) {
    const auto split = [](const std::string& line) {
        std::vector<std::string> words;
        std::istringstream stream(line);
        for (std::string word; std::getline(stream, word, ',');)
            words.push_back(word);
        return words;
    };
    std::ifstream stream(file);
    std::string line;
    Csv csv;
    std::getline(stream, line);
    csv.names = split(line);
    while (std::getline(stream, line)) {
        csv.words.push_back(split(line));
        std::vector<double> row;
        for (const std::string& word : csv.words.back())
            row.push_back(std::strtod(word.c_str(), nullptr));
        EXPECT_EQ(row.size(), csv.names.size());
        csv.rows.push_back(row);
    }
    return csv;
}

/// A folder of its own for each test, removed afterwards.
class CommandTest : public ::testing::Test {
  protected:
    void SetUp() override {
        std::string name = (std::filesystem::temp_directory_path() / "gudgeon-XXXXXX").string();
        ASSERT_NE(mkdtemp(name.data()), nullptr);
        folder_ = name;
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return path(name);
    }

    std::filesystem::path folder_;
};

/// A body thrown up with 3 m/s, nothing else.
inline const char* free_body = R"({"gudgeon": 1, "name": "thrown", "parameters": {"m": 2, "up": 3},
  "bodies": [{"name": "stone", "mass": "m", "inertia": [1, 1, 1], "velocity": [0.5, 0, "up"]}]})";

/// A cart driven along X at 1 m/s drags a bob that hangs from the origin on 1 m and from the cart on
/// 1 m: taut, and locked, when the cart is 2 m from the origin, at t = 1.5 s.
inline const char* locking = R"({"gudgeon": 1, "name": "locking",
  "bodies": [{"name": "cart", "mass": 1, "inertia": [1, 1, 1], "position": [0.5, 0, 0], "velocity": [1, 0, 0]},
             {"name": "bob", "mass": 1, "inertia": [1, 1, 1], "position": [0.25, 0, -0.96824583655185426]}],
  "joints": [{"name": "rail", "kind": "translation", "bodies": ["ground", "cart"], "point": [0.5, 0, 0],
              "axis": [1, 0, 0], "drives": {"slide": {"kind": "ramp", "rate": 1}}},
             {"name": "left", "kind": "distance", "bodies": ["ground", "bob"],
              "points": [[0, 0, 0], [0.25, 0, -0.96824583655185426]], "length": 1},
             {"name": "right", "kind": "distance", "bodies": ["cart", "bob"],
              "points": [[0.5, 0, 0], [0.25, 0, -0.96824583655185426]], "length": 1}]})";

} // namespace gudgeon::test
