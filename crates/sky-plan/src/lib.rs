//! A scene to the cheapest configuration that it needs, found by measuring.
//!
//! A scene gives ranges and a tolerance; the truth is the transport engine with every constituent at
//! 10 nm. First what cannot be seen is left out of the air, then a table is searched for, then the rest
//! follows. The tolerance holds for the 95th percentile of the directions of cases that were not
//! fitted; the search aims at a little less, for cases that it has not seen. Out of scope: other
//! formulas than the extended one, orders of scattering.

pub mod explain;
pub mod plan;
pub mod planning;
pub mod scene;
mod search;
mod space;
mod text;

pub use explain::{visibility, zenith_without_ozone};
pub use plan::{Axes, Expected, Plan, PlannedAerial, PlannedTier};
pub use planning::{Planned, plan_scene, verified, verify_plan};
pub use scene::{Scene, Tolerance};
