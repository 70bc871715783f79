//! Tests of the whole; see `run.sh`.
