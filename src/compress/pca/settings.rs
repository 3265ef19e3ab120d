//! How to find principal components.

/// What the components pass through.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Centre {
    /// The mean of the rows: components describe deviations from it.
    #[default]
    Mean,
    /// The origin: components describe the rows themselves, as in a truncated singular value decomposition. A product
    /// with a light then has no constant term.
    Origin,
}

/// How components are found.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum PcaMethod {
    /// [`Exact`](Self::Exact) where the smaller side of the matrix is at most twice the sketch, otherwise
    /// [`Randomised`](Self::Randomised).
    #[default]
    Auto,
    /// All eigenvectors of the smaller of the two Gram matrices, in `f64`. Time and memory grow with the square of the
    /// smaller side, and its cube.
    Exact,
    /// Subspace iteration from a random matrix [Halko, Martinsson & Tropp 2011, algorithm 4.4, of the transpose].
    Randomised,
}

/// Settings of [`Pca`](crate::compress::Pca).
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct PcaSettings {
    /// Most components to keep.
    pub components: usize,
    /// What they pass through.
    pub centre: Centre,
    /// How they are found.
    pub method: PcaMethod,
    /// Randomised: columns of the sketch beyond the components, default 10. Too few and the last components are poor;
    /// each costs as much as a component.
    pub oversampling: usize,
    /// Randomised: rounds of A Aᵀ, default 2. Each divides the error of what the sketch missed by the square of the
    /// ratio of singular values and costs two products in one pass over the matrix; with none, slowly falling variances
    /// (noise) give components that are wrong by a few per cent. At most 1000.
    pub power_iterations: usize,
    /// Randomised: seed of the random matrix.
    pub seed: u64,
}

impl PcaSettings {
    /// At most `components`, about the mean, the method chosen by size.
    pub fn new(components: usize) -> Self {
        Self {
            components,
            centre: Centre::Mean,
            method: PcaMethod::Auto,
            oversampling: 10,
            power_iterations: 2,
            seed: 0,
        }
    }

    /// The same about another centre.
    #[must_use]
    pub fn with_centre(self, centre: Centre) -> Self {
        Self { centre, ..self }
    }

    /// The same by another method.
    #[must_use]
    pub fn with_method(self, method: PcaMethod) -> Self {
        Self { method, ..self }
    }

    /// The same with another oversampling of the sketch.
    #[must_use]
    pub fn with_oversampling(self, oversampling: usize) -> Self {
        Self { oversampling, ..self }
    }

    /// The same with another number of power iterations.
    #[must_use]
    pub fn with_power_iterations(self, power_iterations: usize) -> Self {
        Self { power_iterations, ..self }
    }

    /// The same from another seed.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }
}
