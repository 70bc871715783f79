//! Where long work tells how far it is; who shows it is not known here.

/// Told of work as it goes on, from any thread. What begins ends before what was begun earlier.
pub trait Progress: Sync {
    /// Work begins: its name, and how many steps it has where that is known.
    fn begin(&self, what: &'static str, steps: Option<usize>);

    /// A step of the work that was begun last is done.
    fn step(&self);

    /// The work that was begun last is done.
    fn end(&self);
}

/// Tells nobody.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _: &'static str, _: Option<usize>) {}

    fn step(&self) {}

    fn end(&self) {}
}
