// Checkpoints, interrupted and killed runs that go on, and what stands in their way.
#include "app/file_tools.hpp"
#include "core/archive.hpp"
#include "core/reader.hpp"
#include "tests/app/command_tools.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace gudgeon {
namespace {

using namespace test;
namespace fs = std::filesystem;

/// The program itself in a process of its own, silent; files: largest size it may write, 0: any.
pid_t start(std::vector<std::string> args, rlim_t files = 0) {
    args.insert(args.begin(), GUDGEON_EXE);
    std::vector<char*> words;
    for (std::string& word : args)
        words.push_back(word.data());
    words.push_back(nullptr);
    const pid_t child = fork();
    if (child == 0) {
        const int null = open("/dev/null", O_WRONLY);
        dup2(null, 1);
        dup2(null, 2);
        if (files > 0) {
            signal(SIGXFSZ, SIG_IGN);
            const rlimit limit{files, files};
            setrlimit(RLIMIT_FSIZE, &limit);
        }
        execv(words[0], words.data());
        _exit(127);
    }
    return child;
}

int wait_for(pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

nlohmann::json timeless(const fs::path& folder) {
    nlohmann::json s = summary_in(folder);
    for (const char* key : {"cpu_seconds", "cpu_seconds_by_phase", "wall_seconds", "settings"})
        s.erase(key);
    return s;
}

class Resume : public CommandTest {
  protected:
    void expect_same(const std::string& straight, const std::string& resumed) {
        for (const char* name : {"trajectory.csv", "trajectory.h5", "steps.csv", "contacts.csv"})
            EXPECT_TRUE(text_of(folder_ / straight / name) == text_of(folder_ / resumed / name)) << name;
        EXPECT_EQ(timeless(folder_ / straight), timeless(folder_ / resumed));
        EXPECT_FALSE(fs::exists(folder_ / resumed / "checkpoint.gudgeon"));
    }
    /// Waits until a checkpoint is there.
    void wait_for_checkpoint(const std::string& folder) {
        for (int i = 0; i < 3000 && !fs::exists(folder_ / folder / "checkpoint.gudgeon"); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        ASSERT_TRUE(fs::exists(folder_ / folder / "checkpoint.gudgeon"));
    }
    /// A run that was interrupted on its way, in `out`.
    void interrupt_run(const std::vector<std::string>& more = {}) {
        std::vector<std::string> args{"run",     "chain", "--param",      "links=4", "--end", "1e5",
                                      "--every", "1",     "--checkpoint", "1",       "--out", path("out")};
        args.insert(args.end(), more.begin(), more.end());
        const pid_t child = start(args);
        wait_for_checkpoint("out");
        kill(child, SIGINT);
        ASSERT_EQ(wait_for(child), 130);
    }
};

TEST_F(Resume, KilledRunsEndAlike) {
    const std::vector<std::vector<std::string>> cases{
        {"slider-crank", "--param", "joint=spherical", "--integrator", "gear", "--end", "2"},
        {"slider-crank", "--param", "joint=revolute", "--integrator", "radau", "--end", "0.5"},
        {"slider-crank", "--param", "joint=spherical", "--integrator", "rk4", "--step", "2e-5", "--end",
         "0.3"},
        {"stick-slip", "--integrator", "auto", "--end", "100"}};
    for (const std::vector<std::string>& model : cases) {
        fs::remove_all(folder_ / "straight");
        fs::remove_all(folder_ / "killed");
        std::vector<std::string> args{"run"};
        args.insert(args.end(), model.begin(), model.end());
        args.insert(args.end(), {"--steps", "--contacts", "--quiet", "--out", path("straight")});
        ASSERT_EQ(command(args).code, 0);
        args.back() = path("killed");
        args.insert(args.end(), {"--checkpoint", "0.005"});
        pid_t child = start(args);
        wait_for_checkpoint("killed");
        for (const int wait : {20, 60, 40}) {
            std::this_thread::sleep_for(std::chrono::milliseconds(wait));
            kill(child, SIGKILL);
            const int code = wait_for(child);
            if (code == 0)
                break; // done before it was killed
            ASSERT_EQ(code, -SIGKILL);
            child = start({"resume", path("killed"), "--quiet"});
        }
        const int code = wait_for(child);
        ASSERT_TRUE(code == 0 || code == -1) << code;
        expect_same("straight", "killed");
    }
}

TEST_F(Resume, InterruptedRunGoesOnWithTheModelAsItWas) {
    const std::string model = write("stone.json", free_body);
    const std::vector<std::string> args{"run",   model, "--param", "up=7",       "--step", "1e-4",
                                        "--end", "20",  "--steps", "--contacts", "--out"};
    std::vector<std::string> straight = args, cut = args;
    straight.push_back(path("straight"));
    ASSERT_EQ(command(straight).code, 0);
    cut.push_back(path("cut"));
    const pid_t child = start(cut);
    for (int i = 0; i < 3000 && !fs::exists(folder_ / "cut/steps.csv"); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    kill(child, SIGTERM);
    if (wait_for(child) != 130)
        GTEST_SKIP() << "the run was over before the signal";
    EXPECT_EQ(summary_in(folder_ / "cut")["status"], "interrupted");
    fs::rename(folder_ / "cut", folder_ / "moved"); // the folder may move, the model may change
    write("stone.json", "{}");
    const Outcome outcome = command({"resume", path("moved")});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("changed since"), std::string::npos) << outcome.err;
    expect_same("straight", "moved");
    const Outcome again = command({"resume", path("moved")});
    EXPECT_EQ(again.code, 2);
    EXPECT_NE(again.err.find("has ended"), std::string::npos) << again.err;
}

TEST_F(Resume, IdaStartsAnewAndSaysSo) {
    std::vector<std::string> args{"run",          "chain", "--integrator", "ida",      "--param",
                                  "links=4",      "--end", "40",           "--every",  "0.01",
                                  "--checkpoint", "0.1",   "--out",        path("out")};
    const pid_t child = start(args);
    wait_for_checkpoint("out");
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    kill(child, SIGKILL);
    ASSERT_EQ(wait_for(child), -SIGKILL);
    const Outcome outcome = command({"resume", path("out")});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("ida starts anew at t = "), std::string::npos) << outcome.err;
    EXPECT_EQ(summary_in(folder_ / "out")["restarts"].size(), 1u);
    EXPECT_EQ(read_csv(folder_ / "out/trajectory.csv").rows.size(), 4001u);
}

TEST_F(Resume, DamagedCheckpointsAreRefused) {
    interrupt_run();
    const fs::path file = folder_ / "out/checkpoint.gudgeon";
    const std::string good = text_of(file), csv = text_of(folder_ / "out/trajectory.csv");
    const auto refused = [&](const std::string& bytes, const std::string& words) {
        std::ofstream(file, std::ios::binary) << bytes;
        const Outcome outcome = command({"resume", path("out")});
        EXPECT_EQ(outcome.code, 5) << words;
        EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
        EXPECT_NE(outcome.err.find("checkpoint.gudgeon"), std::string::npos) << outcome.err;
    };
    refused(good.substr(0, good.size() - 1), "is truncated");
    refused(good.substr(0, 20), "is truncated");
    refused("", "is truncated");
    refused("t,x\n0,1\n", "is no checkpoint");
    std::string other = good;
    other[8] = 99; // the format
    refused(other, "format 99; allowed: 1");
    for (const std::size_t at : {std::size_t{40}, good.size() / 2, good.size() - 1}) {
        other = good;
        other[at] ^= 4;
        refused(other, "is damaged");
    }
    EXPECT_TRUE(text_of(folder_ / "out/trajectory.csv") == csv); // none of these touches the results
    std::ofstream(file, std::ios::binary) << good;
    fs::resize_file(folder_ / "out/trajectory.csv", 100);
    const Outcome shorter = command({"resume", path("out")});
    EXPECT_EQ(shorter.code, 5);
    EXPECT_NE(shorter.err.find("has 100 bytes"), std::string::npos) << shorter.err;
}

TEST_F(Resume, WithoutACheckpoint) {
    const Outcome none = command({"resume", path("nowhere")});
    EXPECT_EQ(none.code, 5);
    EXPECT_NE(none.err.find("no checkpoint to go on from"), std::string::npos) << none.err;
    interrupt_run();
    // a new run must not leave the checkpoint of the old one beside its results
    EXPECT_EQ(command({"run", "chain", "--end", "0.1", "--quiet", "--out", path("out")}).code, 0);
    EXPECT_FALSE(fs::exists(folder_ / "out/checkpoint.gudgeon"));
}

TEST_F(Resume, FullDiskIsReportedAndTheRunGoesOnLater) {
    // no file may grow beyond 60 kB
    const std::vector<std::string> model{"run", "chain",   "--param",    "links=4", "--end",
                                         "20",  "--steps", "--contacts", "--quiet", "--out"};
    std::vector<std::string> straight = model, full = model;
    straight.push_back(path("straight"));
    full.insert(full.end(), {path("full"), "--checkpoint", "0.5"});
    ASSERT_EQ(command(straight).code, 0);
    EXPECT_EQ(wait_for(start(full, 60000)), 5);
    ASSERT_TRUE(fs::exists(folder_ / "full/checkpoint.gudgeon"));
    EXPECT_EQ(summary_in(folder_ / "full")["status"], "failed");
    EXPECT_NE(summary_in(folder_ / "full")["reason"].get<std::string>().find("cannot be written"),
              std::string::npos);
    EXPECT_EQ(command({"resume", path("full"), "--quiet"}).code, 0);
    expect_same("straight", "full");
}

TEST_F(Resume, ResultsThatCannotFitAreFoundBeforeTheRun) {
    // 9e7 times x 1900 columns; the run ends early, by a force that overflows
    std::string bodies;
    for (int i = 0; i < 100; ++i)
        bodies += (i ? "," : "") + std::string(R"({"mass": 1, "inertia": [1, 1, 1], "name": "b)") +
                  std::to_string(i) + "\"}";
    const std::string model =
        write("many.json", R"({"gudgeon": 1, "name": "many", "bodies": [)" + bodies + R"(],
      "forces": [{"name": "shove", "kind": "force", "body": "b0", "vector": [1e300, 0, 0], "point": [0, 0, 0],
                  "time": {"kind": "smooth-step", "start": 0.5, "end": 0.6, "from": 0, "to": 1e300}}]})");
    const Outcome outcome =
        command({"run", model, "--end", "9e7", "--every", "1", "--quiet", "--out", path("out")});
    EXPECT_EQ(outcome.code, 4) << outcome.err;
    EXPECT_NE(outcome.err.find("the disk will be full before the end: 90000001 times x"), std::string::npos)
        << outcome.err;
}

TEST(FileTools, DeviceWithoutSpace) {
    OutputFile full("/dev/full");
    try {
        full.write("x");
        FAIL() << "written";
    } catch (const FileError& error) {
        EXPECT_NE(std::string(error.what()).find("No space left"), std::string::npos) << error.what();
    }
}

TEST(FileTools, SizesInWords) {
    EXPECT_EQ(size_in_words(999), "999 bytes");
    EXPECT_EQ(size_in_words(1.5e9), "1.5 GB");
    EXPECT_EQ(size_in_words(2e16), "2e+04 TB");
}

} // namespace
} // namespace gudgeon
