#include "model/kinetics.hpp"

#include "model/papers/cosine.hpp"
#include "model/papers/duhem.hpp"
#include "model/papers/liang_rogers.hpp"
#include "model/wire/three_phase/three_phase.hpp"
#include "tests/model/kinetics_suite.hpp"
#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test::kinetics_test {
namespace {

struct ThreePhaseDouble {
  using Model = ThreePhase<double>;
  static Model::Params params() { return paper_wire().kinetics; }
  static constexpr InnerLoops loops = InnerLoops::close;
  static constexpr double rounding = 1e-12;
};

struct ThreePhaseEveryReversal : ThreePhaseDouble {
  static Model::Params params() {
    Model::Params p = paper_wire().kinetics;
    p.smallest_reversal_K = 0;
    return p;
  }
};

struct ThreePhaseFloat : ThreePhaseDouble {
  using Model = ThreePhase<float>;
  static Model::Params params() { return kinetics_for<float>(paper_wire().kinetics); }
  static constexpr double rounding = 1e-5;
};

struct ThreePhasePlain : ThreePhaseDouble {
  static Model::Params params() { return plain_kinetics(); }
  static constexpr InnerLoops loops = InnerLoops::ratchet;
};

struct ThreePhaseSeparate : ThreePhaseDouble {
  static Model::Params params() { return separate_kinetics(); }
  static constexpr int order = 2;
};

struct ThreePhaseOrdered : ThreePhaseDouble {
  static Model::Params params() { return ordered_kinetics(); }
};

struct ThreePhaseOrderedFloat : ThreePhaseFloat {
  static Model::Params params() { return kinetics_for<float>(ordered_kinetics()); }
};

struct CosineDouble {
  using Model = papers::Cosine<double>;
  static Model::Params params() { return flexinol_cosine<double>(); }
  static constexpr InnerLoops loops = InnerLoops::dead_band;
  static constexpr double rounding = 1e-12;
};

struct CosineFloat : CosineDouble {
  using Model = papers::Cosine<float>;
  static Model::Params params() { return flexinol_cosine<float>(); }
  static constexpr double rounding = 1e-5;
};

/// No memory, and a Gaussian is never quite over: every ripple on a slope converts a little.
struct DuhemDouble {
  using Model = papers::Duhem<double>;
  static Model::Params params() { return flexinol_duhem<double>(); }
  static constexpr InnerLoops loops = InnerLoops::ratchet;
  static constexpr double rounding = 1e-12;
};

struct DuhemFloat : DuhemDouble {
  using Model = papers::Duhem<float>;
  static Model::Params params() { return flexinol_duhem<float>(); }
  static constexpr double rounding = 1e-5;
};

struct LiangRogersDouble : CosineDouble {
  using Model = papers::LiangRogers<double>;
  static Model::Params params() { return flexinol_liang_rogers<double>(); }
};

struct LiangRogersFloat : CosineFloat {
  using Model = papers::LiangRogers<float>;
  static Model::Params params() { return flexinol_liang_rogers<float>(); }
};

struct SubjectName {
  template <class Subject>
  static std::string GetName(int /*index*/) {
    if constexpr (std::is_same_v<Subject, ThreePhaseDouble>) {
      return "ThreePhaseDouble";
    }
    if constexpr (std::is_same_v<Subject, ThreePhaseEveryReversal>) {
      return "ThreePhaseEveryReversal";
    }
    if constexpr (std::is_same_v<Subject, ThreePhaseFloat>) {
      return "ThreePhaseFloat";
    }
    if constexpr (std::is_same_v<Subject, ThreePhasePlain>) {
      return "ThreePhasePlain";
    }
    if constexpr (std::is_same_v<Subject, ThreePhaseSeparate>) {
      return "ThreePhaseSeparate";
    }
    if constexpr (std::is_same_v<Subject, ThreePhaseOrdered>) {
      return "ThreePhaseOrdered";
    }
    if constexpr (std::is_same_v<Subject, ThreePhaseOrderedFloat>) {
      return "ThreePhaseOrderedFloat";
    }
    if constexpr (std::is_same_v<Subject, CosineDouble>) {
      return "CosineDouble";
    }
    if constexpr (std::is_same_v<Subject, CosineFloat>) {
      return "CosineFloat";
    }
    if constexpr (std::is_same_v<Subject, DuhemDouble>) {
      return "DuhemDouble";
    }
    if constexpr (std::is_same_v<Subject, DuhemFloat>) {
      return "DuhemFloat";
    }
    if constexpr (std::is_same_v<Subject, LiangRogersDouble>) {
      return "LiangRogersDouble";
    }
    if constexpr (std::is_same_v<Subject, LiangRogersFloat>) {
      return "LiangRogersFloat";
    }
  }
};

using All =
    ::testing::Types<ThreePhaseDouble, ThreePhaseEveryReversal, ThreePhaseFloat, ThreePhasePlain,
                     ThreePhaseSeparate, ThreePhaseOrdered, ThreePhaseOrderedFloat, CosineDouble,
                     CosineFloat, DuhemDouble, DuhemFloat, LiangRogersDouble, LiangRogersFloat>;
using Exact =
    ::testing::Types<ThreePhaseDouble, ThreePhaseEveryReversal, ThreePhaseFloat, ThreePhasePlain,
                     ThreePhaseOrdered, ThreePhaseOrderedFloat, CosineDouble, CosineFloat,
                     DuhemDouble, DuhemFloat, LiangRogersDouble, LiangRogersFloat>;
using Inexact = ::testing::Types<ThreePhaseSeparate>;
using InDouble =
    ::testing::Types<ThreePhaseDouble, ThreePhaseEveryReversal, ThreePhasePlain, ThreePhaseSeparate,
                     ThreePhaseOrdered, CosineDouble, DuhemDouble, LiangRogersDouble>;
using WithMemory = ::testing::Types<ThreePhaseDouble, ThreePhaseEveryReversal, ThreePhaseFloat,
                                    ThreePhaseSeparate, ThreePhaseOrdered, ThreePhaseOrderedFloat>;
INSTANTIATE_TYPED_TEST_SUITE_P(Kinetics, KineticsSuite, All, SubjectName);
INSTANTIATE_TYPED_TEST_SUITE_P(Kinetics, ExactSteps, Exact, SubjectName);
INSTANTIATE_TYPED_TEST_SUITE_P(Kinetics, StepOrder, Inexact, SubjectName);
INSTANTIATE_TYPED_TEST_SUITE_P(Kinetics, BranchRates, InDouble, SubjectName);
INSTANTIATE_TYPED_TEST_SUITE_P(Kinetics, ReturnPoints, WithMemory, SubjectName);

}  // namespace
}  // namespace smaservo::test::kinetics_test
