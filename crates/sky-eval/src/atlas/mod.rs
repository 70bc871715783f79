//! The atlas: where every model fails, found by a sweep over its domain and beyond.
//!
//! [`subject::models`] is the list of models, the published ones included, and [`kind::KINDS`] that of
//! failures; [`sweep`] asks every model the same questions. Nothing depends on the clock or on the
//! number of threads. Out of scope: whether an answer is right (`report`, `chart`).

pub mod kind;
pub mod page;
pub mod panorama;
pub mod rows;
pub mod subject;
pub mod sweep;
