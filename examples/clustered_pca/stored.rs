//! The rows of a matrix as means, components and weights, and these in fewer bits.

use haarmonic::Result;
use haarmonic::compress::{
    ByteBlocks, ClusteredPca, ClusteredPcaSettings, Pca, PcaSettings, QuantisedBytes, QuantisedHalf,
};

/// How the numbers are stored; labels of clusters take as many bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Single,
    Half,
    Byte,
}

impl Format {
    pub const ALL: [Self; 3] = [Self::Single, Self::Half, Self::Byte];

    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "f32",
            Self::Half => "f16",
            Self::Byte => "8 bit",
        }
    }

    fn label_bytes(self) -> usize {
        match self {
            Self::Single => 4,
            Self::Half => 2,
            Self::Byte => 1,
        }
    }

    /// What is left of numbers, and the bytes that they take.
    fn through(self, values: &[f32], columns: usize, blocks: ByteBlocks) -> Result<(Vec<f32>, usize)> {
        let mut left = values.to_vec();
        let bytes = match self {
            _ if values.is_empty() => 0,
            Self::Single => size_of_val(values),
            Self::Half => {
                let stored = QuantisedHalf::new(values)?;
                stored.decode(&mut left);
                stored.bytes()
            }
            Self::Byte => {
                let stored = QuantisedBytes::new(values, columns, blocks)?;
                stored.decode(&mut left);
                stored.bytes()
            }
        };
        Ok((left, bytes))
    }
}

/// Rows that share a mean and components.
struct Cluster {
    /// The mean, then the components.
    basis: Vec<f32>,
    members: Vec<usize>,
    /// Of each member in turn.
    weights: Vec<f32>,
}

/// All rows; principal components of the whole matrix are one cluster.
pub struct Stored {
    columns: usize,
    rows: usize,
    clusters: Vec<Cluster>,
}

impl Stored {
    pub fn pca(matrix: &[f32], columns: usize, components: usize, seed: u64) -> Result<Self> {
        let rows = matrix.len() / columns;
        let pca = Pca::new(matrix, columns, &PcaSettings::new(components).with_seed(seed))?;
        let mut weights = vec![0.0; rows * pca.len()];
        pca.project(matrix, &mut weights);
        let basis = [pca.mean(), pca.components()].concat();
        Ok(Self { columns, rows, clusters: vec![Cluster { basis, members: (0..rows).collect(), weights }] })
    }

    /// Also as the crate has it.
    pub fn clustered(
        matrix: &[f32],
        columns: usize,
        settings: &ClusteredPcaSettings,
    ) -> Result<(Self, ClusteredPca<f32>)> {
        let coded = ClusteredPca::new(matrix, columns, settings, &())?;
        let k = coded.components();
        let cluster = |c: usize| {
            let (mean, components) = coded.cluster(c);
            let members: Vec<usize> = (0..coded.rows()).filter(|&row| coded.labels()[row] as usize == c).collect();
            let weights = members.iter().flat_map(|row| &coded.weights()[row * k..][..k]).copied().collect();
            Cluster { basis: [mean, components].concat(), members, weights }
        };
        let clusters = (0..coded.clusters()).map(cluster).collect();
        Ok((Self { columns, rows: coded.rows(), clusters }, coded))
    }

    pub fn clusters(&self) -> usize {
        self.clusters.len()
    }

    /// Components of a cluster: weights of a row.
    pub fn components(&self) -> usize {
        self.clusters[0].basis.len() / self.columns - 1
    }

    /// The matrix that is left, and the bytes of all that is stored.
    ///
    /// In 8 bits each mean, each component, and each cluster's weights of one component have an offset and a step of
    /// their own.
    pub fn decode(&self, format: Format) -> Result<(Vec<f32>, usize)> {
        let (columns, k) = (self.columns, self.components());
        let mut matrix = vec![0.0; self.rows * columns];
        let mut bytes = if self.clusters() > 1 { self.rows * format.label_bytes() } else { 0 };
        for cluster in &self.clusters {
            let (mut basis, basis_bytes) = format.through(&cluster.basis, columns, ByteBlocks::Rows)?;
            let (weights, weight_bytes) = format.through(&cluster.weights, k, ByteBlocks::Columns)?;
            bytes += basis_bytes + weight_bytes;
            let components = basis.split_off(columns);
            // Variances play no part in reconstruction.
            let pca = Pca::from_parts(basis, components, vec![0.0; k], 0.0)?;
            let mut rows = vec![0.0; cluster.members.len() * columns];
            pca.reconstruct(&weights, &mut rows);
            for (&member, row) in cluster.members.iter().zip(rows.chunks_exact(columns)) {
                matrix[member * columns..][..columns].copy_from_slice(row);
            }
        }
        Ok((matrix, bytes))
    }
}

/// Components of `clusters` clusters that take no more numbers than principal components of the whole matrix do.
pub fn components_of_equal_size(rows: usize, columns: usize, clusters: usize, whole: usize) -> usize {
    // clusters·(k + 1)·columns + rows·(k + 1), the label counted as a number, against columns + whole·(columns + rows).
    let budget = columns + whole * (columns + rows);
    (budget / (clusters * columns + rows)).saturating_sub(1)
}
