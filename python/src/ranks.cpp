// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "ranks.h"

#include "struct_class.h"

namespace pliant::python {
namespace {

/// A view of numbers that live until the call returns.
template <class T>
nb::object view_of(std::span<T> numbers) {
    using Number = std::conditional_t<std::is_const_v<T>, const double, double>;
    return nb::cast(
        nb::ndarray<nb::numpy, Number, nb::ndim<1>>(numbers.data(), {numbers.size()}, nb::handle()),
        nb::rv_policy::reference);
}

class Communicator : public Ranks {
  public:
    explicit Communicator(nb::object comm)
        : m_comm(std::move(comm)),
          m_rank(nb::cast<int>(m_comm.attr("Get_rank")())),
          m_count(nb::cast<int>(m_comm.attr("Get_size")())) {}
    ~Communicator() override {
        const nb::gil_scoped_acquire lock;
        m_comm.reset();
    }

    int rank() const override { return m_rank; }
    int count() const override { return m_count; }

    void exchange(std::span<const double> to_below, std::span<const double> to_above,
                  std::span<double> from_below, std::span<double> from_above) override {
        const nb::gil_scoped_acquire lock;
        pass_on(to_below, m_rank - 1, from_above, m_rank + 1);
        pass_on(to_above, m_rank + 1, from_below, m_rank - 1);
    }

    void gather(std::span<const double> mine, std::span<const std::size_t> counts,
                std::span<double> all) override {
        const nb::gil_scoped_acquire lock;
        nb::list numbers;
        for (const std::size_t count : counts) numbers.append(count);
        m_comm.attr("Allgatherv")(view_of(mine), nb::make_tuple(view_of(all), numbers));
    }

  private:
    void pass_on(std::span<const double> sent, int to, std::span<double> received, int from) {
        using nb::literals::operator""_a;
        if (sent.empty() && received.empty()) return;
        if (received.empty()) {
            m_comm.attr("Send")(view_of(sent), "dest"_a = to);
        } else if (sent.empty()) {
            m_comm.attr("Recv")(view_of(received), "source"_a = from);
        } else {
            m_comm.attr("Sendrecv")(view_of(sent), "dest"_a = to, "recvbuf"_a = view_of(received),
                                    "source"_a = from);
        }
    }

    nb::object m_comm;
    int m_rank, m_count;
};

}  // namespace

std::unique_ptr<Ranks> ranks_of(const nb::object& comm) {
    for (const char* name : {"Get_rank", "Get_size", "Send", "Recv", "Sendrecv", "Allgatherv"})
        if (!nb::hasattr(comm, name)) raise_value("comm", "a communicator of mpi4py", comm);
    return std::make_unique<Communicator>(comm);
}

}  // namespace pliant::python
