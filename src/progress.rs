//! Progress and cancellation of long work.

/// Watches long work and may stop it.
///
/// The work calls [`advance`](Progress::advance) from any of its threads, at most some hundred times a second, and asks
/// [`is_cancelled`](Progress::is_cancelled) between pieces. `()` watches nothing and never stops.
pub trait Progress: Sync {
    /// `done` of `total` pieces are finished. Calls may arrive out of order.
    fn advance(&self, done: usize, total: usize) {
        let _ = (done, total);
    }
    /// Whether to stop now; the work then returns [`Error::Cancelled`](crate::Error::Cancelled).
    fn is_cancelled(&self) -> bool {
        false
    }
}

impl Progress for () {}
