//! An image as a list of terms.

use crate::approx_eq::approx_by_parts;
use crate::haar::{Decomposition, Keep, ScalingTerms, Selection, SparseVector, Transform2d, Weighting};
use crate::{Error, Real, Result};

/// A compressed picture: the terms of its standard Haar basis that were kept, each with a value in every channel.
///
/// The picture has `width` × `height` pixels, any numbers; it lies at the beginning of a *grid* whose sides are the
/// next powers of two, [`grid`](Self::grid), and is 0 in the rest of the grid and beyond. What this type does, it does
/// to the whole grid; only [`to_pixels`](Self::to_pixels) cuts at the frame. So a zoom into a picture of 1200 × 900
/// pixels has in the rest of its grid what lies beside the window.
///
/// Shapes: channels are planes of `width` · `height` pixels, row-major; a term's index is k_y · grid width + k_x of
/// [`Decomposition::Standard`].
/// Memory: [`bytes`](Self::bytes), 4 and C numbers a term.
///
/// # Example
/// ```
/// use haarmonic::affine::{WaveletImage, ZoomWindow};
/// use haarmonic::haar::Keep;
/// // 4 × 2 pixels; the window is the middle half of both axes, at 2 × 2 pixels.
/// let pixels = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
/// let image = WaveletImage::from_pixels([4, 2], [&pixels], Keep::Fraction(1.0))?;
/// let zoom = image.zoom(ZoomWindow::new([0.5, 0.5], [2.0, 2.0])?, [2, 2])?;
/// assert_eq!(zoom.to_pixels(), [[2.0, 3.0, 6.0, 7.0]]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(
        into = "Stored<T>",
        try_from = "Stored<T>",
        bound(serialize = "T: Real + serde::Serialize", deserialize = "T: Real + serde::Deserialize<'de>")
    )
)]
#[derive(Debug, Clone, PartialEq)]
pub struct WaveletImage<T, const C: usize = 1> {
    pub(super) size: [usize; 2],
    pub(super) indices: Vec<u32>,
    pub(super) values: Vec<[T; C]>,
}

/// As it is stored: the values plane by plane, because arrays of any length have no form of their own there.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "WaveletImage")]
struct Stored<T> {
    width: usize,
    height: usize,
    indices: Vec<u32>,
    channels: Vec<Vec<T>>,
}

#[cfg(feature = "serde")]
impl<T: Real, const C: usize> From<WaveletImage<T, C>> for Stored<T> {
    fn from(image: WaveletImage<T, C>) -> Self {
        let channels = (0..C).map(|c| image.values.iter().map(|value| value[c]).collect()).collect();
        let [width, height] = image.size;
        Self { width, height, indices: image.indices, channels }
    }
}

#[cfg(feature = "serde")]
impl<T: Real, const C: usize> TryFrom<Stored<T>> for WaveletImage<T, C> {
    type Error = Error;

    fn try_from(stored: Stored<T>) -> Result<Self> {
        let count = stored.indices.len();
        if stored.channels.len() != C {
            return Err(Error::Length { what: "channels of an image", expected: C, got: stored.channels.len() });
        }
        if let Some(channel) = stored.channels.iter().find(|channel| channel.len() != count) {
            return Err(Error::Length { what: "values of a channel", expected: count, got: channel.len() });
        }
        let values = (0..count).map(|k| std::array::from_fn(|c| stored.channels[c][k])).collect();
        Self::new([stored.width, stored.height], stored.indices, values)
    }
}

/// The largest side of a picture.
const LARGEST: usize = 1 << 15;

/// The grid of a picture: its sides rounded up to powers of two.
///
/// # Errors
/// [`Error::Empty`] for a side of 0, [`Error::OutOfRange`] above 2¹⁵.
pub(super) fn grid_of(size: [usize; 2]) -> Result<[usize; 2]> {
    for side in size {
        if side == 0 {
            return Err(Error::Empty { what: "side of an image" });
        }
        if side > LARGEST {
            return Err(Error::OutOfRange { what: "side of an image", got: side as f64, allowed: "at most 32768" });
        }
    }
    Ok(size.map(usize::next_power_of_two))
}

impl<T: Real, const C: usize> WaveletImage<T, C> {
    /// The picture of `size` = [width, height] pixels with the given terms.
    ///
    /// # Errors
    /// [`Error::Empty`] if a side is 0; [`Error::OutOfRange`] above a side of 32768, and unless the indices ascend
    /// strictly and are below the area of the [`grid`](Self::grid); [`Error::Length`] unless there is a value an index;
    /// [`Error::NotFinite`] for values that are not.
    pub fn new(size: [usize; 2], indices: Vec<u32>, values: Vec<[T; C]>) -> Result<Self> {
        let [across, down] = grid_of(size)?;
        if indices.len() != values.len() {
            return Err(Error::Length {
                what: "values of an image's terms",
                expected: indices.len(),
                got: values.len(),
            });
        }
        let mut next = 0u64;
        for &i in &indices {
            if u64::from(i) < next || i as usize >= across * down {
                let allowed = "above the index before it and below the area of the grid";
                return Err(Error::OutOfRange { what: "index of an image's term", got: f64::from(i), allowed });
            }
            next = u64::from(i) + 1;
        }
        if let Some(index) = values.iter().position(|value| value.iter().any(|v| !v.is_finite())) {
            return Err(Error::NotFinite { what: "value of an image's term", index });
        }
        Ok(Self { size, indices, values })
    }

    /// A picture without terms: 0 everywhere.
    ///
    /// # Errors
    /// [`Error::Empty`] if a side is 0; [`Error::OutOfRange`] above a side of 32768.
    pub fn zero(size: [usize; 2]) -> Result<Self> {
        Self::new(size, Vec::new(), Vec::new())
    }

    /// As [`zero`](Self::zero), of a size that has been checked.
    pub(super) fn empty(size: [usize; 2]) -> Self {
        Self { size, indices: Vec::new(), values: Vec::new() }
    }

    /// The terms of a picture's pixels that `keep` asks for: those of largest √(Σ c²) over the channels, and the mean
    /// always, as [`Selection`] with [`Weighting::Magnitude`]. A fraction is one of the grid's area.
    ///
    /// That choice makes the error of the picture as small as it can be with as many terms, in the mean square. Terms
    /// that are 0 are left out, so that `Keep::Fraction(1.0)` is the picture itself, losslessly but for rounding.
    ///
    /// # Errors
    /// [`Error::Empty`] if a side is 0 or there are no channels; [`Error::OutOfRange`] above a side of 32768 and for a
    /// fraction outside [0, 1]; [`Error::Length`] unless each channel has width · height pixels; [`Error::NotFinite`]
    /// for coefficients that are not, which NaN and infinite pixels make.
    pub fn from_pixels(size: [usize; 2], channels: [&[T]; C], keep: Keep) -> Result<Self> {
        let [across, down] = grid_of(size)?;
        let [width, height] = size;
        if let Some(channel) = channels.iter().find(|channel| channel.len() != width * height) {
            return Err(Error::Length { what: "pixels of a channel", expected: width * height, got: channel.len() });
        }
        let transform = Transform2d::new(across, down, Decomposition::Standard)?;
        let mut memory = vec![T::zero(); transform.scratch_len()];
        let planes = channels.map(|channel| {
            let mut plane = vec![T::zero(); across * down];
            for (to, from) in plane.chunks_exact_mut(across).zip(channel.chunks_exact(width)) {
                to[..width].copy_from_slice(from);
            }
            transform.forward_in_place(&mut plane, &mut memory);
            plane
        });
        Self::select(size, planes.each_ref().map(Vec::as_slice), keep)
    }

    /// The terms of dense coefficients that `keep` asks for, without zeros.
    pub(super) fn select(size: [usize; 2], planes: [&[T]; C], keep: Keep) -> Result<Self> {
        let selection = Selection::new(keep).with_weighting(Weighting::Magnitude);
        let kept = selection.apply_channels(planes)?;
        let mut image = Self::empty(size);
        let indices = kept.first().map_or(&[][..], SparseVector::indices);
        for (at, &index) in indices.iter().enumerate() {
            image.push(index, std::array::from_fn(|c| kept[c].values()[at]));
        }
        Ok(image)
    }

    /// A picture f(x) g(y) of the samples of f and g, one value for all channels: gradients and rectangles, of few
    /// terms each, as masks.
    ///
    /// Its terms are the products of theirs: a rectangle has about 4 log² of the side, a gradient along one axis the
    /// axis' length.
    ///
    /// # Errors
    /// As [`from_pixels`](Self::from_pixels), of the number of samples.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::WaveletImage;
    /// let down = WaveletImage::<f64>::from_separable(&[1.0, 1.0], &[0.0, 0.25, 0.75, 1.0])?;
    /// assert_eq!(down.to_pixels(), [[0.0, 0.0, 0.25, 0.25, 0.75, 0.75, 1.0, 1.0]]);
    /// assert_eq!(down.terms(), 4);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn from_separable(f: &[T], g: &[T]) -> Result<Self> {
        let size = [f.len(), g.len()];
        let [across, _] = grid_of(size)?;
        let row = WaveletImage::from_pixels([f.len(), 1], [f], Keep::Fraction(1.0))?;
        let column = WaveletImage::from_pixels([1, g.len()], [g], Keep::Fraction(1.0))?;
        let mut image = Self::empty(size);
        for (&y, &[b]) in column.indices.iter().zip(&column.values) {
            for (&x, &[a]) in row.indices.iter().zip(&row.values) {
                image.push(y * across as u32 + x, [a * b; C]);
            }
        }
        Ok(image)
    }

    /// The picture of sparse coefficients (standard basis of the grid), one vector a channel; a term that a channel
    /// lacks is 0 there.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::Length`] unless each vector is as long as the grid's area.
    pub fn from_sparse(size: [usize; 2], channels: [&SparseVector<T>; C]) -> Result<Self> {
        let [across, down] = grid_of(size)?;
        if let Some(channel) = channels.iter().find(|channel| channel.len() != across * down) {
            return Err(Error::Length {
                what: "coefficients of a channel",
                expected: across * down,
                got: channel.len(),
            });
        }
        let mut iterators = channels.map(|channel| channel.iter().peekable());
        let (mut indices, mut values) = (Vec::new(), Vec::new());
        while let Some(next) = iterators.iter_mut().filter_map(|i| i.peek().map(|&(at, _)| at)).min() {
            let of = |i: &mut std::iter::Peekable<_>| i.next_if(|&(at, _)| at == next).map_or(T::zero(), |(_, v)| v);
            values.push(iterators.each_mut().map(of));
            indices.push(next as u32);
        }
        Self::new(size, indices, values)
    }

    /// The terms of one channel.
    ///
    /// # Panics
    /// Unless `channel` < C.
    #[track_caller]
    pub fn channel(&self, channel: usize) -> SparseVector<T> {
        assert!(channel < C, "channel {channel} of {C}");
        let [across, down] = self.grid();
        let values = self.values.iter().map(|value| value[channel]).collect();
        SparseVector::new(across * down, self.indices.clone(), values).expect("the image has checked its indices")
    }

    /// The terms of dense coefficients, without zeros.
    pub(super) fn from_dense(size: [usize; 2], planes: [&[T]; C]) -> Self {
        let mut image = Self::empty(size);
        for i in 0..planes.first().map_or(0, |plane| plane.len()) {
            image.push(i as u32, std::array::from_fn(|c| planes[c][i]));
        }
        image
    }

    /// The pixels of the picture: decompression.
    ///
    /// Cost: an inverse transform of the grid a channel; allocates.
    pub fn to_pixels(&self) -> [Vec<T>; C] {
        let [across, down] = self.grid();
        let [width, height] = self.size;
        let mut plane = vec![T::zero(); across * down];
        let transform = Transform2d::new(across, down, Decomposition::Standard).expect("the grid's sides are 2^k");
        let mut memory = vec![T::zero(); transform.scratch_len()];
        std::array::from_fn(|c| {
            self.write_channel(c, &mut plane);
            transform.inverse_in_place(&mut plane, &mut memory);
            plane.chunks_exact(across).take(height).flat_map(|row| &row[..width]).copied().collect()
        })
    }

    /// One channel as dense coefficients of the grid.
    pub(super) fn write_channel(&self, c: usize, plane: &mut [T]) {
        plane.fill(T::zero());
        for (&index, value) in self.indices.iter().zip(&self.values) {
            plane[index as usize] = value[c];
        }
    }

    /// The terms that `keep` asks for, as [`from_pixels`](Self::from_pixels) chooses: compresses further.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a fraction outside [0, 1]; [`Error::NotFinite`] where sums of earlier calls have left
    /// the range of T.
    pub fn kept(&self, keep: Keep) -> Result<Self> {
        keep.check()?;
        let [across, down] = self.grid();
        if keep.of(across * down) >= self.terms() {
            return Ok(self.clone());
        }
        // Ranked among themselves: the list is as long as there are terms, and the mean, where it is one, the first.
        let scaling = if self.indices.first() == Some(&0) { ScalingTerms::Always } else { ScalingTerms::Compete };
        let planes: [Vec<T>; C] = std::array::from_fn(|c| self.values.iter().map(|value| value[c]).collect());
        let selection = Selection::new(Keep::Terms(keep.of(across * down))).with_weighting(Weighting::Magnitude);
        let mut work = Default::default();
        let planes = planes.each_ref().map(Vec::as_slice);
        let places = selection.with_scaling_terms(scaling).indices(&planes, &mut work)?;
        let mut image = Self::empty(self.size);
        for &at in places {
            image.push(self.indices[at as usize], self.values[at as usize]);
        }
        Ok(image)
    }

    /// Appends a term of a higher index, unless it is 0 in all channels.
    #[inline(always)]
    pub(super) fn push(&mut self, index: u32, value: [T; C]) {
        if value.iter().any(|&v| v != T::zero()) {
            self.indices.push(index);
            self.values.push(value);
        }
    }

    /// [width, height] of the picture.
    #[inline]
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// [width, height] of the grid that the basis stands on: the picture's sides, rounded up to powers of two.
    #[inline]
    pub fn grid(&self) -> [usize; 2] {
        self.size.map(usize::next_power_of_two)
    }

    /// How many terms there are.
    #[inline]
    pub fn terms(&self) -> usize {
        self.indices.len()
    }

    /// The terms' flat indices k_y · grid width + k_x, strictly ascending.
    #[inline]
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// The terms' values.
    #[inline]
    pub fn values(&self) -> &[[T; C]] {
        &self.values
    }

    /// Bytes of the terms: 4 for the index of each, and the numbers.
    #[inline]
    pub fn bytes(&self) -> usize {
        self.terms() * (size_of::<u32>() + size_of::<[T; C]>())
    }
}

approx_by_parts!(
    [T: Real + approx::RelativeEq<Epsilon = T> + approx::UlpsEq<Epsilon = T>, const C: usize] WaveletImage<T, C>, T,
    |i| close [i.values.as_flattened()] same [i.size, &i.indices]
);
