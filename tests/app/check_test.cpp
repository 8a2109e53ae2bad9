// `check`, `list`, `export`, and every refused model through the command line.
#include "app/command_tools.hpp"

#include "bench/hard_cases/singular_models.hpp"
#include "core/reader.hpp"
#include "core/writer.hpp"
#include "models/mechanisms.hpp"

namespace gudgeon {
namespace {

using nlohmann::json;
using test::command;
using test::Outcome;

class Check : public test::CommandTest {};

void expect_words(const std::string& text, const std::vector<std::string>& words) {
    for (const std::string& word : words)
        EXPECT_NE(text.find(word), std::string::npos) << text << "\nlacks " << word;
}

/// The value of a line "label   value".
std::string line_of(const std::string& text, const std::string& label) {
    const std::size_t at = text.find(label + " ");
    if (at == std::string::npos)
        return "";
    const std::size_t value = text.find_first_not_of(' ', at + label.size());
    return text.substr(value, text.find('\n', value) - value);
}

TEST_F(Check, SliderCrank) {
    const Outcome outcome = command({"check", "slider-crank"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(line_of(outcome.out, "bodies"), "3 moving, 0 fixed");
    EXPECT_EQ(line_of(outcome.out, "joints"), "4 (1 revolute, 1 spherical, 1 translation, 1 universal)");
    EXPECT_EQ(line_of(outcome.out, "unknowns"), "18 velocities, 17 constraint rows");
    EXPECT_EQ(line_of(outcome.out, "degrees of freedom"), "1");
    EXPECT_EQ(line_of(outcome.out, "redundant rows"), "0");
    EXPECT_EQ(line_of(outcome.out, "tree"),
              "3 joints, depth 2, 0 free bodies, 4 joint coordinates, 4 speeds");
    EXPECT_EQ(line_of(outcome.out, "cuts"), "3 rows of 1 joints: 'B'");
    EXPECT_EQ(line_of(outcome.out, "matrix").substr(0, 8), "35 x 35,");
    EXPECT_EQ(line_of(outcome.out, "columns of output"), std::to_string(3 * 19 + 13 + 18 + 14 + 13 + 6));
}

TEST_F(Check, BushingsAndFixedBodies) {
    const Outcome outcome = command({"check", "hmmwv-corner", "--param", "joints=bushing"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(line_of(outcome.out, "bodies"), "5 moving, 1 fixed");
    expect_words(outcome.out, {"2 revolute bushing", "1 tyre"});
}

TEST_F(Check, RedundantRowsByName) {
    const Outcome outcome = command({"check", "four-bar"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(line_of(outcome.out, "degrees of freedom"), "1"); // 18 - 20 rows + 3 that repeat others
    EXPECT_EQ(line_of(outcome.out, "redundant rows"), "3");
    expect_words(outcome.out, {"'C1' (tilt about t) repeats", "'A1'", "L = 0.5 m"});
}

TEST_F(Check, StartsThatSingleOutNoMotionAreRefusedAsRunsAre) {
    const std::string model = write("flat.json", write_model(hard::flat_chain({1, 0})));
    for (const char* verb : {"check", "run"}) {
        const Outcome outcome = command({verb, model});
        EXPECT_EQ(outcome.code, 3) << verb;
        expect_words(outcome.err, {"singular position", "'A0' (displacement along x)"});
    }
}

TEST_F(Check, ChangesByAssembly) {
    const std::string model = write("hanging.json", R"({"gudgeon": 1,
        "bodies": [{"name": "stone", "mass": 1, "inertia": [1, 1, 1], "position": [0, 0, -1.25]}],
        "joints": [{"name": "rod", "kind": "distance", "bodies": ["ground", "stone"], "points": [[0, 0, 0], [0, 0, -1.25]], "length": 1}]})");
    const Outcome outcome = command({"check", model});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(line_of(outcome.out, "violation as given").substr(0, 4), "0.25");
    EXPECT_EQ(line_of(outcome.out, "  stone").substr(0, 4), "0.25");
    EXPECT_EQ(line_of(outcome.out, "degrees of freedom"), "5");
}

TEST_F(Check, MechanismThatCannotClose) {
    const std::string model = write("open.json", R"({"gudgeon": 1,
        "bodies": [{"name": "stone", "mass": 1, "inertia": [1, 1, 1], "position": [1, 0, 0]}],
        "joints": [{"name": "here", "kind": "distance", "bodies": ["ground", "stone"], "points": [[0, 0, 0], [1, 0, 0]], "length": 1},
                   {"name": "there", "kind": "distance", "bodies": ["ground", "stone"], "points": [[5, 0, 0], [1, 0, 0]], "length": 1}]})");
    const Outcome outcome = command({"check", model});
    EXPECT_EQ(outcome.code, 3);
    expect_words(outcome.err, {model + ": ", "cannot be assembled", "'here'", "'there'", "distance"});
}

TEST_F(Check, EveryReadyMechanism) {
    for (const Mechanism& m : mechanisms()) {
        const Outcome outcome = command({"check", m.name});
        EXPECT_EQ(outcome.code, 0) << m.name << outcome.err;
    }
}

TEST_F(Check, RefusedModelsWithPlaceAndValue) {
    const json table = json::parse(test::text_of(GUDGEON_TEST_DATA "/bad_inputs.json"));
    int cases = 0;
    const auto run = [&](const json& entry, const char* text, const char* patch, const char* parameters) {
        const std::string file =
            write("model.json", entry.contains(text) ? entry[text].get<std::string>()
                                                     : table["base"].patch(entry[patch]).dump(1));
        std::vector<std::string> args{"check", file};
        if (entry.contains(parameters))
            for (const auto& [name, value] : entry[parameters].items()) {
                args.push_back("--param");
                args.push_back(name + "=" + value.dump());
            }
        return command(args);
    };
    for (const json& entry : table["cases"]) {
        SCOPED_TRACE(entry["category"].get<std::string>() + ": " + entry["name"].get<std::string>());
        const Outcome bad = run(entry, "text", "patch", "parameters");
        const auto pointer = entry["pointer"].get<std::string>();
        EXPECT_EQ(bad.code, 2) << bad.err;
        EXPECT_EQ(bad.err.find(path("model.json") + ": " + (pointer.empty() ? "" : pointer + ": ")), 0u)
            << bad.err;
        expect_words(bad.err, {entry["value"].get<std::string>(), "; allowed: "});
        const Outcome twin = run(entry, "twin_text", "twin", "twin_parameters");
        EXPECT_NE(twin.code, 2) << twin.err;
        ++cases;
    }
    EXPECT_GE(cases, 60);
}

TEST_F(Check, ParameterThatIsNoNumber) {
    const std::string model = write("stone.json", test::free_body);
    const Outcome outcome = command({"check", model, "--param", "m=heavy"});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(outcome.err,
              model + ": /parameters/m: 'heavy' is no finite number; allowed: a finite number\n");
    expect_words(command({"check", model, "--param", "n=1"}).err, {"no parameter 'n'", "m, up"});
    expect_words(command({"check", model, "--param", "m=-1"}).err, {"/bodies/0/mass", "-1"});
}

TEST_F(Check, MessagesOfReadyMechanisms) {
    const Outcome outcome = command({"check", "chain", "--param", "links=x"});
    EXPECT_EQ(outcome.code, 2);
    expect_words(outcome.err, {"chain: /parameters/links: ", "\"x\"", "; allowed: "});
    EXPECT_EQ(outcome.err.find("allowed: allowed:"), std::string::npos) << outcome.err;
}

TEST_F(Check, ListNamesEverything) {
    const Outcome outcome = command({"list"});
    EXPECT_EQ(outcome.code, 0);
    for (const Mechanism& m : mechanisms()) {
        expect_words(outcome.out, {m.name + ": " + m.description});
        for (const MechanismParameter& p : m.parameters) {
            expect_words(outcome.out, {p.name, p.default_value, p.help});
            expect_words(outcome.out, p.choices);
        }
    }
}

TEST_F(Check, ExportReadsBackAsTheSameModel) {
    const Outcome outcome = command({"export", "chain", "--param", "links=3"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const Model model = parse_model(outcome.out, "exported");
    EXPECT_EQ(model.name, "chain");
    ASSERT_EQ(model.bodies.size(), 3u);
    EXPECT_EQ(model.bodies[2].position, (Vec3(2.5, 0, 0)));
    const std::string file = write("chain.json", outcome.out);
    ASSERT_EQ(command({"run", file, "--end", "0.05", "--out", path("a")}).code, 0);
    ASSERT_EQ(command({"run", "chain", "--param", "links=3", "--end", "0.05", "--out", path("b")}).code, 0);
    EXPECT_EQ(test::text_of(path("a") + "/trajectory.csv"), test::text_of(path("b") + "/trajectory.csv"));
}

} // namespace
} // namespace gudgeon
