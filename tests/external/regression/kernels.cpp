// A kernel of a program that uses Gudgeon: a millisecond of a chain, counted from the same point every time.
#include <counted.hpp>
#include <gudgeon/models/mechanisms.hpp>
#include <gudgeon/solvers/simulation.hpp>

#include <memory>
#include <stdexcept>

int main(int argc, char** argv) {
    const counted::Kernel chain{"chain", [] {
                                    auto sim = std::make_shared<gudgeon::Simulation>(
                                        gudgeon::build_mechanism("chain", {{"links", "4"}}));
                                    const gudgeon::State start = sim->state();
                                    return counted::Work{[sim] {
                                                             if (!sim->advance_to(1e-3).ok)
                                                                 throw std::runtime_error("the chain stops");
                                                         },
                                                         [sim, start] { sim->restore(start); },
                                                         {}};
                                }};
    return counted::run(argc, argv, {chain}, {});
}
