//! A progress bar on standard error that long work of the crate can drive.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use haarmonic::Progress;
use indicatif::{ProgressBar, ProgressStyle};

/// A bar with a title, the share done and the time left; plain lines where standard error is not a terminal.
pub struct Bar {
    bar: ProgressBar,
    title: &'static str,
    started: Instant,
    furthest: AtomicUsize,
}

impl Bar {
    /// Starts a bar.
    pub fn new(title: &'static str) -> Self {
        let bar = ProgressBar::new(0);
        let style = ProgressStyle::with_template("{msg:28} [{bar:32}] {percent:>3} %  {elapsed} (left {eta})");
        bar.set_style(style.expect("the template is valid").progress_chars("=> "));
        bar.set_message(title);
        bar.enable_steady_tick(Duration::from_millis(250));
        Self { bar, title, started: Instant::now(), furthest: AtomicUsize::new(0) }
    }

    /// Ends the bar with a line that stays, and returns the seconds it took.
    pub fn finish(self) -> f64 {
        let seconds = self.started.elapsed().as_secs_f64();
        self.bar.finish_and_clear();
        #[expect(clippy::print_stderr, reason = "an example talks to its user")]
        {
            eprintln!("{:28} {seconds:7.2} s", self.title);
        }
        seconds
    }
}

impl Progress for Bar {
    fn advance(&self, done: usize, total: usize) {
        self.bar.set_length(total as u64);
        let before = self.furthest.fetch_max(done, Ordering::Relaxed);
        self.bar.set_position(before.max(done) as u64);
    }
}
