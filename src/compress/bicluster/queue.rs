//! A priority queue whose priorities are small integers.

const NONE: u32 = u32::MAX;

/// Items 0…n−1 in buckets by key; taking the best, moving and removing cost O(1) plus the size of the top bucket.
///
/// An item with key 0 is not in the queue.
#[derive(Debug, Clone)]
pub(super) struct BucketQueue {
    keys: Vec<u32>,
    /// The first item of each bucket.
    heads: Vec<u32>,
    next: Vec<u32>,
    previous: Vec<u32>,
    /// No item has a larger key.
    top: usize,
}

impl BucketQueue {
    pub(super) fn new(items: usize) -> Self {
        let links = vec![NONE; items];
        Self { keys: vec![0; items], heads: vec![NONE; 2], next: links.clone(), previous: links, top: 0 }
    }

    /// Gives `item` a key; 0 takes it out.
    #[inline]
    pub(super) fn set(&mut self, item: usize, key: u32) {
        if self.keys[item] == key {
            return;
        }
        self.unlink(item);
        self.keys[item] = key;
        if key == 0 {
            return;
        }
        let bucket = key as usize;
        if bucket >= self.heads.len() {
            self.heads.resize(bucket * 2, NONE);
        }
        let first = std::mem::replace(&mut self.heads[bucket], item as u32);
        (self.next[item], self.previous[item]) = (first, NONE);
        if first != NONE {
            self.previous[first as usize] = item as u32;
        }
        self.top = self.top.max(bucket);
    }

    #[inline]
    fn unlink(&mut self, item: usize) {
        let key = self.keys[item] as usize;
        if key == 0 {
            return;
        }
        let (next, previous) = (self.next[item], self.previous[item]);
        if previous == NONE {
            self.heads[key] = next;
        } else {
            self.next[previous as usize] = next;
        }
        if next != NONE {
            self.previous[next as usize] = previous;
        }
    }

    /// The largest key and the smallest item that has it, if the key is at least `least`.
    pub(super) fn best(&mut self, least: u32) -> Option<(u32, usize)> {
        while self.top > 0 && self.heads[self.top] == NONE {
            self.top -= 1;
        }
        if self.top == 0 || self.top < least as usize {
            return None;
        }
        let (mut item, mut best) = (self.heads[self.top], NONE);
        while item != NONE {
            best = best.min(item);
            item = self.next[item as usize];
        }
        Some((self.top as u32, best as usize))
    }
}
