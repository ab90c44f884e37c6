// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace enfilade::localization {

// How a robot is located in maps by its scans (Localize).
struct LocalizationOptions {
  // --- The scans.
  double max_range = 30.0;      // m: farther hits are ignored
  int min_hits = 30;            // point_spacing apart, of a scan that is searched
  double scan_spacing = 0.25;   // m or rad between the scans used
  int max_scans = 12;           // used at most, evenly chosen
  double point_spacing = 0.05;  // m between neighbouring points of a scan that is refined
  int search_points = 100;      // of a scan, in the search
  int beams = 180;              // of a scan, when it is compared with a map

  // --- The search over all positions and headings.
  double search_cell = 0.10;         // m
  double search_sigma = 0.15;        // m, of the likelihood: broad, to bear coarse steps and small changes
  double min_score = 0.35;           // mean likelihood of a scan's points, below which a place is not considered
  double min_relative_score = 0.78;  // the same, as a share of the best place's score
  double mode_distance = 0.6;        // m: of places nearer than this with headings nearer than mode_angle,
  double mode_angle = 0.3;           // rad: only the best is considered
  int max_modes = 80;                // per map and scan searched
  int max_expansions = 3'000'000;    // blocks looked at per map and scan searched

  // --- How likely a beam is at a pose (after the beam model of Thrun, Burgard, Fox, 2005, section 6.3). A hit at the
  // distance d from the map's nearest wall: exp(-d^2 / (2 hit_sigma^2)), but at least the following.
  double hit_sigma = 0.10;
  double unknown_likelihood = 0.20;  // it ends where the map is unknown
  double free_likelihood = 0.05;     // it ends in free space of the map: something new, or another place
  double through_likelihood = 0.02;  // it passes through a wall of the map (whatever it ends at)
  double matched_distance = 0.15;    // m, from a hit to the wall that it is on
  // Neighbouring beams err together, and so do neighbouring scans: a scan counts as this many independent beams, each
  // further scan as this share of a scan.
  double effective_beams = 40.0;
  double further_scan = 0.35;

  // --- When a pose is listed, and when it is certain. "Odds" are differences of log-likelihoods.
  double min_matched = 0.35;    // share of all hits on walls, below which no place is known
  double min_agreement = 0.60;  // the same of the hits on known ground
  double listed_odds = 40.0;    // a pose that is farther behind the best is not listed
  // Every rival must be this far behind, and this many times as far as the best itself is from a perfect fit: the worse
  // it fits, the less its lead says.
  double confident_odds = 12.0;
  double confident_misfit = 1.5;
  // So must every place where at least this share of the hits lies on known ground, by those alone: what nobody has
  // seen may look like the best place.
  double tenable_known = 0.25;
  double confident_matched = 0.80;       // share on walls, of the hits on known ground
  double confident_contradicted = 0.08;  // share of all hits in free space or behind walls, at most
  double confident_known = 0.70;         // share of the hits on known ground
  double confident_sigma = 0.25;         // m, of the position in its least certain direction
  double confident_yaw_sigma = 0.09;     // rad
  // Poses nearer to each other than this are the same.
  double same_distance = 0.5;  // m
  double same_angle = 0.17;    // rad (10 deg)
  // Standard deviations added to a pose, for what matching does not model.
  double sigma_floor = 0.025;  // m
  double yaw_floor = 0.006;    // rad

  // --- A prior pose bounds the search: this many standard deviations and, in addition, so much.
  double prior_sigmas = 4.0;
  double prior_distance = 1.0;  // m
  double prior_angle = 0.3;     // rad
};

}  // namespace enfilade::localization
