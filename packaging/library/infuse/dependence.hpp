#pragma once

/// @file
/// Estimators of the statistical dependence between two sets of samples.

#include "fusion/dependence/bagged_lsmi.hpp"
#include "fusion/dependence/estimate.hpp"
#include "fusion/dependence/histogram_measures.hpp"
#include "fusion/dependence/joint_histogram.hpp"
#include "fusion/dependence/label_dependence.hpp"
#include "fusion/dependence/prepared_dependence.hpp"
#include "fusion/dependence/prepared_histogram.hpp"
#include "fusion/dependence/shrunk_information.hpp"
#include "infuse/layout.hpp"
