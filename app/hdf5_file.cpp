#include "app/hdf5_file.hpp"

#include "core/reader.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <utility>

namespace gudgeon {

namespace {

/// An identifier of the library and how it is closed.
class Handle {
  public:
    using Close = herr_t (*)(hid_t);
    Handle(hid_t id, Close close) : id_(id), close_(close) {}
    ~Handle() {
        if (id_ >= 0)
            close_(id_);
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    hid_t operator*() const { return id_; }

  private:
    hid_t id_;
    Close close_;
};

hid_t create(const std::filesystem::path& file) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); // errors are ours to report
    return H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
}

hid_t text_type() {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}

} // namespace

struct Hdf5File::Impl {
    std::filesystem::path path;
    std::size_t columns, block; // block: rows kept before they are written
    Handle file, text, t, values;
    std::vector<double> times, rows;
    hsize_t written = 0;

    Impl(const std::filesystem::path& p, std::size_t n)
        : path(p), columns(n), block(std::clamp<std::size_t>(32768 / std::max<std::size_t>(n, 1), 16, 1024)),
          file(create(p), H5Fclose), text(text_type(), H5Tclose), t(table("t", 1), H5Dclose),
          values(table("values", 2), H5Dclose) {
        times.reserve(block);
        rows.reserve(block * columns);
    }

    void check(bool good) const {
        if (!good)
            throw FileError(fmt::format("{}: cannot be written (HDF5)", path.string()));
    }

    /// Without rows, extendible in time.
    hid_t table(const char* name, int rank) const {
        check(*file >= 0);
        const std::array<hsize_t, 2> size{0, columns}, limit{H5S_UNLIMITED, columns}, chunk{block, columns};
        const Handle space(H5Screate_simple(rank, size.data(), limit.data()), H5Sclose);
        const Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
        check(H5Pset_chunk(*layout, rank, chunk.data()) >= 0);
        check(H5Pset_obj_track_times(*layout, false) >= 0); // the same results, the same file
        const hid_t set = H5Dcreate2(*file, name, H5T_IEEE_F64LE, *space, H5P_DEFAULT, *layout, H5P_DEFAULT);
        check(set >= 0);
        return set;
    }

    void texts(const char* name, const std::vector<std::string>& lines) const {
        std::vector<const char*> pointers;
        for (const std::string& line : lines)
            pointers.push_back(line.c_str());
        const hsize_t size = lines.size();
        const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
        const Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
        check(H5Pset_obj_track_times(*layout, false) >= 0);
        const Handle set(H5Dcreate2(*file, name, *text, *space, H5P_DEFAULT, *layout, H5P_DEFAULT), H5Dclose);
        check(*set >= 0 && H5Dwrite(*set, *text, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) >= 0);
    }

    void attribute(const std::string& name, hid_t type, hid_t memory_type, const void* value) const {
        if (H5Aexists(*file, name.c_str()) > 0)
            H5Adelete(*file, name.c_str());
        const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
        const Handle made(H5Acreate2(*file, name.c_str(), type, *space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
        check(*made >= 0 && H5Awrite(*made, memory_type, value) >= 0);
    }

    void extend(hid_t set, int rank, const std::vector<double>& data) const {
        const std::array<hsize_t, 2> from{written, 0}, count{times.size(), columns},
            size{written + times.size(), columns};
        check(H5Dset_extent(set, size.data()) >= 0);
        const Handle all(H5Dget_space(set), H5Sclose);
        check(H5Sselect_hyperslab(*all, H5S_SELECT_SET, from.data(), nullptr, count.data(), nullptr) >= 0);
        const Handle memory(H5Screate_simple(rank, count.data(), nullptr), H5Sclose);
        check(H5Dwrite(set, H5T_NATIVE_DOUBLE, *memory, *all, H5P_DEFAULT, data.data()) >= 0);
    }

    void write_rows() {
        if (times.empty())
            return;
        extend(*t, 1, times);
        extend(*values, 2, rows);
        written += times.size();
        times.clear();
        rows.clear();
    }
};

Hdf5File::Hdf5File(const std::filesystem::path& file, const std::vector<std::string>& names,
                   const std::vector<std::string>& units)
    : impl_(std::make_unique<Impl>(file, names.size())) {
    impl_->texts("names", names);
    impl_->texts("units", units);
}

Hdf5File::~Hdf5File() = default;

void Hdf5File::attribute(const std::string& name, const std::string& value) {
    const char* text = value.c_str();
    impl_->attribute(name, *impl_->text, *impl_->text, &text);
}

void Hdf5File::attribute(const std::string& name, double value) {
    impl_->attribute(name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5File::append(double t, std::span<const double> values) {
    impl_->times.push_back(t);
    impl_->rows.insert(impl_->rows.end(), values.begin(), values.end());
    if (impl_->times.size() == impl_->block)
        flush();
}

void Hdf5File::flush() {
    impl_->write_rows();
    impl_->check(H5Fflush(*impl_->file, H5F_SCOPE_LOCAL) >= 0);
}

} // namespace gudgeon
