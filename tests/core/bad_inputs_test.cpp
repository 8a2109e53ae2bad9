// The table of models that must be refused, each beside the closest model that must pass; and the
// published schema against the same table.
#include "core/reader.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include <fstream>
#include <set>

namespace gudgeon {
namespace {

using nlohmann::json;

json load(const std::string& file) {
    std::ifstream stream(file);
    return json::parse(stream);
}

const json& table() {
    static const json all = load(GUDGEON_TEST_DATA "/bad_inputs.json");
    return all;
}

std::string label(const json& entry) {
    return entry["category"].get<std::string>() + ": " + entry["name"].get<std::string>();
}

std::string text_of(const json& entry, const char* text, const char* patch) {
    if (entry.contains(text))
        return entry[text].get<std::string>();
    return table()["base"].patch(entry[patch]).dump(1);
}

std::map<std::string, double> parameters_of(const json& entry, const char* key) {
    return entry.contains(key) ? entry[key].get<std::map<std::string, double>>()
                               : std::map<std::string, double>{};
}

TEST(BadInputs, TableIsLargeEnough) {
    std::set<std::string> categories, labels;
    for (const json& entry : table()["cases"]) {
        categories.insert(entry["category"].get<std::string>());
        EXPECT_TRUE(labels.insert(label(entry)).second) << label(entry);
    }
    EXPECT_GE(labels.size(), 60u);
    EXPECT_GE(categories.size(), 12u);
}

TEST(BadInputs, EachIsRefusedWithPlaceAndValue) {
    for (const json& entry : table()["cases"]) {
        SCOPED_TRACE(label(entry));
        const auto pointer = entry["pointer"].get<std::string>();
        const auto value = entry["value"].get<std::string>();
        try {
            parse_model(text_of(entry, "text", "patch"), "bad.json", parameters_of(entry, "parameters"));
            ADD_FAILURE() << "accepted";
        } catch (const ModelError& error) {
            const std::string message = error.what();
            EXPECT_EQ(error.pointer(), pointer) << message;
            EXPECT_NE(message.find(value), std::string::npos) << message << "\nlacks " << value;
            const std::string place = pointer.empty() ? "bad.json: " : "bad.json: " + pointer + ": ";
            EXPECT_EQ(message, place + error.problem() + "; allowed: " + error.allowed());
            EXPECT_FALSE(error.problem().empty());
            EXPECT_FALSE(error.allowed().empty());
        }
    }
}

TEST(BadInputs, EachTwinPasses) {
    for (const json& entry : table()["cases"]) {
        SCOPED_TRACE(label(entry));
        EXPECT_NO_THROW(parse_model(text_of(entry, "twin_text", "twin"), "twin.json",
                                    parameters_of(entry, "twin_parameters")));
    }
}

class Schema : public testing::Test {
  protected:
    Schema() {
        const valijson::adapters::NlohmannJsonAdapter document(document_);
        valijson::SchemaParser().populateSchema(document, schema_);
    }

    bool accepts(const json& model) {
        const valijson::adapters::NlohmannJsonAdapter target(model);
        return valijson::Validator().validate(schema_, target, nullptr);
    }

  private:
    json document_ = load(GUDGEON_SOURCE_DIR "/models/gudgeon.schema.json");
    valijson::Schema schema_;
};

TEST_F(Schema, AcceptsTheExamplesAndEveryTwin) {
    for (const char* name : {"double-pendulum", "mast", "rubber-mount", "slider-crank", "worn-hinge"})
        EXPECT_TRUE(accepts(load(std::string(GUDGEON_SOURCE_DIR "/models/examples/") + name + ".json")))
            << name;
    EXPECT_TRUE(accepts(table()["base"]));
    for (const json& entry : table()["cases"])
        EXPECT_TRUE(accepts(json::parse(text_of(entry, "twin_text", "twin")))) << label(entry);
}

TEST_F(Schema, RefusesWhatItCanState) {
    std::size_t refused = 0;
    for (const json& entry : table()["cases"]) {
        if (!entry.contains("patch"))
            continue; // no JSON at all, or repeated keys, which a document cannot hold
        const bool expected = !entry["schema"].get<bool>();
        refused += !expected;
        EXPECT_EQ(accepts(table()["base"].patch(entry["patch"])), expected) << label(entry);
    }
    EXPECT_GE(refused, 60u);
}

} // namespace
} // namespace gudgeon
