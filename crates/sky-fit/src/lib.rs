//! From a sky to Perez coefficients and a look-up table.
