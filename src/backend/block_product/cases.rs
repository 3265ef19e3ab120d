//! The cases of algorithm 1 [Inger 2013].

use super::live::Live;
use super::rule::SampleClass;

/// How a block of one vertex and lobe is summed up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Case {
    /// Not at all.
    Nothing,
    /// Line 6, free: weights of 1, 4 or 16 samples.
    Free1,
    Free4,
    Free16,
    /// Line 9, partly hidden: 1 or 4 samples with weights from suffix sums.
    Partly1,
    Partly4,
    /// Line 11: pixel by pixel, free or partly hidden.
    FreePixels,
    PartlyPixels,
}

impl Case {
    const COUNT: usize = 8;

    /// Of so many samples.
    #[inline(always)]
    fn of(class: SampleClass, free: bool) -> Self {
        use Case::*;
        const PARTLY: [Case; 8] = [Nothing, Partly1, Partly4, PartlyPixels, PartlyPixels, Nothing, Nothing, Nothing];
        const FREE: [Case; 8] = [Nothing, Free1, Free4, Free16, FreePixels, Nothing, Nothing, Nothing];
        [PARTLY, FREE][usize::from(free)][class.index() & 7]
    }
}

/// Courses of one vertex and lobe, a list a case: all of a case are summed up one after the other, so that the
/// processor knows what comes.
#[derive(Debug, Clone)]
pub(super) struct Cases {
    /// The courses that contribute, and their cases, as they came.
    found: Vec<(u32, Case)>,
    /// [case][entry]
    lists: [Vec<u32>; Case::COUNT],
}

impl Cases {
    pub(super) fn new(blocks: usize) -> Self {
        Self { found: vec![(0, Case::Nothing); blocks], lists: std::array::from_fn(|_| Vec::with_capacity(blocks)) }
    }

    /// Sorts live blocks by their classes. Most contribute nothing; no branch depends on which.
    #[inline(always)]
    pub(super) fn set(&mut self, live: &[Live], class: impl Fn(&Live) -> SampleClass) {
        let mut count = 0;
        for live in live {
            let case = Case::of(class(live), live.free);
            self.found[count] = (live.course, case);
            count += usize::from(case != Case::Nothing);
        }
        self.lists.iter_mut().for_each(Vec::clear);
        for &(course, case) in &self.found[..count] {
            self.lists[case as usize].push(course);
        }
    }

    /// The courses of a case.
    #[inline(always)]
    pub(super) fn list(&self, case: Case) -> &[u32] {
        &self.lists[case as usize]
    }

    /// All courses that contribute, and their classes; more than 4 samples of one that is partly hidden count as all
    /// pixels.
    pub(super) fn classes(&self) -> impl Iterator<Item = (usize, SampleClass)> + '_ {
        use Case::*;
        let classes = [
            (Free1, SampleClass::ONE),
            (Free4, SampleClass::FOUR),
            (Free16, SampleClass::SIXTEEN),
            (Partly1, SampleClass::ONE),
            (Partly4, SampleClass::FOUR),
            (FreePixels, SampleClass::PIXELS),
            (PartlyPixels, SampleClass::PIXELS),
        ];
        classes
            .into_iter()
            .flat_map(|(case, class)| self.list(case).iter().map(move |&course| (course as usize, class)))
    }
}
