//! What the benches share. README.md says what each harness is for; docs/performance.md has what was measured.
//!
//! What is compared with each other on a noisy machine is timed by [`Jobs`]: every job in turn, over and over, the
//! least and the median of its rounds.

use std::time::{Duration, Instant};

const ROUND: Duration = Duration::from_micros(300);
const ROUNDS: usize = 60;

/// Something to time: a call does `units` of what is counted.
struct Job {
    name: String,
    units: usize,
    call: Box<dyn FnMut()>,
    calls: usize,
    times: Vec<f64>,
}

impl Job {
    fn round(&mut self) -> Duration {
        let start = Instant::now();
        (0..self.calls).for_each(|_| (self.call)());
        start.elapsed()
    }

    /// As many calls as a round wants.
    fn calibrate(&mut self) {
        while self.round() < ROUND {
            self.calls *= 2;
        }
    }

    fn measure(&mut self) {
        let nanoseconds = self.round().as_secs_f64() * 1e9;
        self.times.push(nanoseconds / (self.calls * self.units) as f64);
    }

    #[expect(clippy::print_stdout, reason = "the report is what the program is for")]
    fn report(&mut self) {
        self.times.sort_by(f64::total_cmp);
        let (least, median) = (self.times[0], self.times[self.times.len() / 2]);
        println!("{:<28} least {least:10.3} ns, median {median:10.3} ns", self.name);
    }
}

/// Jobs that are timed in turn.
#[derive(Default)]
pub struct Jobs(Vec<Job>);

impl Jobs {
    /// Adds a job of which a call does `units` of what is counted.
    pub fn add(&mut self, name: impl Into<String>, units: usize, call: impl FnMut() + 'static) {
        self.0.push(Job { name: name.into(), units, call: Box::new(call), calls: 1, times: Vec::new() });
    }

    /// Times the jobs whose names hold all words of the command line, and prints nanoseconds a unit.
    pub fn run(mut self) {
        let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
        self.0.retain(|job| words.iter().all(|word| job.name.contains(word.as_str())));
        self.0.iter_mut().for_each(Job::calibrate);
        for _ in 0..ROUNDS {
            self.0.iter_mut().for_each(Job::measure);
        }
        self.0.iter_mut().for_each(Job::report);
    }
}

/// Ordinary numbers in −1..1, the sequence of peers/directxmath.cpp.
pub fn numbers(len: usize) -> Vec<f32> {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    (0..len).map(|_| next()).collect()
}
