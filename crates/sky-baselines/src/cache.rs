//! Tables that depend on the haze, kept for the turbidity they were last built for.

use std::sync::{Arc, Mutex, PoisonError};

#[derive(Debug)]
pub(crate) struct Cache<T> {
    kept: Mutex<Option<(u64, Arc<T>)>>,
}

impl<T> Default for Cache<T> {
    fn default() -> Self {
        Self {
            kept: Mutex::new(None),
        }
    }
}

impl<T> Cache<T> {
    /// The tables of a turbidity, built if they are not those kept.
    pub(crate) fn get(&self, turbidity: f64, build: impl FnOnce() -> T) -> Arc<T> {
        let key = turbidity.to_bits();
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((of, tables)) = kept.as_ref()
            && *of == key
        {
            return Arc::clone(tables);
        }
        let tables = Arc::new(build());
        *kept = Some((key, Arc::clone(&tables)));
        tables
    }

    /// Puts tables in the place of those kept.
    pub(crate) fn put(&self, turbidity: f64, tables: T) {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        *kept = Some((turbidity.to_bits(), Arc::new(tables)));
    }
}
