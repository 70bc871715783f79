//! The engines, the optics and the fit against published tables, closed forms and skies that are known.

mod color;
mod faults;
mod fit_degenerate;
mod fit_solver;
mod optics;
mod transport;
mod transport_everywhere;
mod transport_limits;
