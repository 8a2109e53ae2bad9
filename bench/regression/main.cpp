// gudgeon_regression: counts the kernels of Gudgeon under callgrind; see README.md.

#include "kernels.hpp"
#include "solvers/block_kernels.hpp"

int main(int argc, char** argv) {
    using namespace gudgeon::kernels;
    gudgeon::use_portable_block_kernels(); // the same on every machine
    std::vector<counted::Kernel> counted_kernels;
    for (const Kernel& kernel : all_kernels())
        counted_kernels.push_back({kernel.name, [kernel] {
                                       return kernel.prepare({kernel.bodies, 1, true});
                                   }});
    return counted::run(
        argc, argv, counted_kernels,
        {{"eigen", GUDGEON_EIGEN}, {"suitesparse", GUDGEON_SUITESPARSE}, {"sundials", GUDGEON_SUNDIALS}});
}
