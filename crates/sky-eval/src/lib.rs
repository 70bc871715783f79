//! How well skies agree with the truth: cases, the truth, scores, and what is told of them.
//!
//! Values in, rows, tables and pages out. The truth is the transport engine; every sky stands behind one
//! trait. Here are also the tables that skies are compared as, and the list of all of them. What a GPU
//! draws or costs is handed in. Out of scope: files, the terminal, the command line.

pub mod atlas;
pub mod bake;
pub mod cases;
pub mod chart;
pub mod constituents;
pub mod dice;
pub mod engine;
pub mod extinction;
pub mod fit_stress;
pub mod grid;
pub mod ledger;
pub mod locus;
pub mod models;
mod perez_table;
pub mod picture;
pub mod profiles;
pub mod progress;
pub mod report;
pub mod score;
pub mod stopwatch;
pub mod tiers;
pub mod truth;
pub mod twin;
