// What every use of CHOLMOD here begins with. Internal: includes its header.
#pragma once

#include "core/sparse.hpp"

#include <vector>

#include <cholmod.h>

namespace gudgeon::cholmod {

/// Starts it for matrices that are ordered before CHOLMOD sees them, factored as L D L^T.
inline void start(cholmod_common& common, int supernodal) {
    cholmod_start(&common);
    common.print = 0;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_NATURAL;
    common.postorder = 0;
    common.final_ll = 0;
    common.supernodal = supernodal;
}

/// The upper triangle of a symmetric matrix, not copied.
inline cholmod_sparse view_upper(CscPattern& upper, std::vector<double>& values) {
    cholmod_sparse a{};
    a.nrow = a.ncol = static_cast<std::size_t>(upper.cols);
    a.nzmax = values.size();
    a.p = upper.col_start.data();
    a.i = upper.row.data();
    a.x = values.data();
    a.stype = 1;
    a.itype = CHOLMOD_INT;
    a.xtype = CHOLMOD_REAL;
    a.dtype = CHOLMOD_DOUBLE;
    a.sorted = a.packed = 1;
    return a;
}

} // namespace gudgeon::cholmod
