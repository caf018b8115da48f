#include "render/session.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <stdexcept>

#include "bindings/bind.h"

namespace nb = nanobind;

namespace vernier {

namespace {

Pass pass_by_name(const std::string& name) {
  for (size_t i = 0; i < kPasses.size(); ++i) {
    if (kPasses[i].name == name || kPasses[i].legacy_name == name) {
      return static_cast<Pass>(i);
    }
  }
  throw std::invalid_argument("there is no pass named " + name);
}

const char* ending_name(Ending ending) {
  switch (ending) {
    case Ending::kSamples:
      return "samples";
    case Ending::kTarget:
      return "target";
    case Ending::kTime:
      return "time";
    case Ending::kCancelled:
      return "cancel";
    case Ending::kFailed:
      return "failure";
    case Ending::kNone:
      break;
  }
  return "";
}

std::string integrator_identifier(int kind) {
  const auto row = std::find_if(parameters().begin(), parameters().end(),
                                [](const Parameter& p) { return p.name == "integrator"; });
  return std::string(row->items[static_cast<size_t>(kind)].identifier);
}

nb::ndarray<nb::numpy, float> read(const Session& session, const std::string& name, int x, int y,
                                   int width, int height) {
  const Pass pass = pass_by_name(name);
  const Film& film = session.film();
  if (x < 0 || y < 0 || width < 0 || height < 0 || x > film.width() - width ||
      y > film.height() - height) {
    throw std::invalid_argument("the rectangle is not within the film");
  }
  if (!film.passes().has(pass)) {
    throw std::invalid_argument("pass " + name + " was not asked for");
  }
  const size_t channels = info(pass).channels.size();
  const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height) * channels;
  auto* data = new float[count]();
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<float*>(p); });
  {
    const nb::gil_scoped_release release;
    film.read(pass, {x, y, width, height}, {data, count});
  }
  return nb::ndarray<nb::numpy, float>(
      data, {static_cast<size_t>(height), static_cast<size_t>(width), channels}, owner);
}

nb::ndarray<nb::numpy, double> estimates(const Session& session) {
  constexpr size_t kFields = 5;
  const Film& film = session.film();
  std::vector<PixelEstimate> pixels;
  {
    const nb::gil_scoped_release release;
    pixels = film.estimates();
  }
  auto* data = new double[kFields * pixels.size()];
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  double* out = data;
  for (const PixelEstimate& p : pixels) {
    for (const double value : {p.mean, p.variance, p.net_gap, p.excess, p.steady_variance}) {
      *out++ = value;
    }
  }
  return nb::ndarray<nb::numpy, double>(
      data, {static_cast<size_t>(film.height()), static_cast<size_t>(film.width()), kFields},
      owner);
}

}  // namespace

void bind_session(nb::module_& m) {
  nb::class_<Progress>(m, "Progress", "Where a render is.")
      .def_ro("samples", &Progress::samples, "Per pixel, on average.")
      .def_ro("samples_target", &Progress::samples_target)
      .def_ro("seconds", &Progress::seconds)
      .def_ro("seconds_left", &Progress::seconds_left, "An estimate; infinite while unknown.")
      .def_ro("error", &Progress::error, "Of the picture; infinite while unknown.")
      .def_ro("rays", &Progress::rays)
      .def_ro("non_finite", &Progress::non_finite, "Samples dropped because not finite.")
      .def_ro("done", &Progress::done)
      .def_ro("cancelled", &Progress::cancelled)
      .def_prop_ro(
          "ending", [](const Progress& p) { return ending_name(p.ending); },
          "What ended it: samples, target, time, cancel or failure; empty while it is not done.");

  nb::class_<Session>(m, "Session", "A render in progress.")
      .def(
          "__init__",
          [](Session* self, nb::handle scene, const std::map<std::string, SettingValue>& settings,
             const std::vector<std::string>& passes, bool give_way, const std::string& resume,
             const std::string& digest) {
            PassSet set;
            for (const std::string& name : passes) {
              set.add(pass_by_name(name));
            }
            const Settings values = make_settings(settings);
            const auto compiled = scene_of(scene);
            const nb::gil_scoped_release release;
            new (self) Session(compiled, values, set, give_way, {resume, digest});
          },
          nb::arg("scene"), nb::arg("settings"), nb::arg("passes"), nb::arg("give_way") = false,
          nb::arg("resume") = "", nb::arg("digest") = "",
          "`give_way`: its threads leave the processor to others of ordinary priority. `resume`: "
          "the "
          "file of a state to go on from, saved for a scene of the same `digest`, any text.")
      .def("save", &Session::save, nb::arg("path"), nb::arg("digest") = "",
           nb::call_guard<nb::gil_scoped_release>(),
           "Writes the state, at any time; the file is there as a whole or not at all.")
      .def("start", &Session::start)
      .def("cancel", &Session::cancel, "Asks the threads to stop; returns at once.")
      .def("wait", &Session::wait, nb::arg("seconds"), nb::call_guard<nb::gil_scoped_release>(),
           "True when all threads have ended; waits at most `seconds`.")
      .def("poll", &Session::poll, nb::arg("with_error") = false,
           nb::call_guard<nb::gil_scoped_release>())
      .def(
          "take_tiles",
          [](Session& s) {
            std::vector<std::tuple<int, int, int, int>> tiles;
            for (const Tile& t : s.take_tiles()) {
              tiles.emplace_back(t.x, t.y, t.width, t.height);
            }
            return tiles;
          },
          "Rectangles (x, y, width, height) that have changed since the last call.")
      .def("read", &read, nb::arg("name"), nb::arg("x"), nb::arg("y"), nb::arg("width"),
           nb::arg("height"), "The current estimate of a pass: (height, width, channels) float32.")
      .def(
          "estimates", &estimates,
          "What each pixel knows by itself: (height, width, 5) float64 of mean, variance, net_gap, "
          "excess and steady_variance (accuracy/pixel_sums.h).")
      .def_prop_ro("threads", &Session::thread_count)
      .def_prop_ro("notes", &Session::notes,
                   "What the integrator leaves out in this scene, a sentence each.")
      .def_prop_ro("choice", &Session::choice,
                   "Why Auto chose the method that renders; empty where the settings name one, and "
                   "while methods are tried.")
      .def_prop_ro(
          "integrator",
          [](const Session& s) { return integrator_identifier(static_cast<int>(s.integrator())); })
      .def_prop_ro("error_message", &Session::error_message);
}

}  // namespace vernier
