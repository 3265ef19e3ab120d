//! Clustered principal components, every step from its definition.

use super::pca::NaivePca;

/// The components of the rows of each label; `None` for a label without rows.
pub fn fit_clusters(rows: &[Vec<f64>], labels: &[usize], clusters: usize) -> Vec<Option<NaivePca>> {
    let fit = |c: usize| {
        let members = rows.iter().zip(labels).filter(|(_, label)| **label == c);
        let members: Vec<Vec<f64>> = members.map(|(row, _)| row.clone()).collect();
        (!members.is_empty()).then(|| NaivePca::new(&members, None))
    };
    (0..clusters).map(fit).collect()
}

/// |x − x'|² in each cluster with its first `components` components; infinite where there is no cluster.
pub fn cluster_distances(row: &[f64], clusters: &[Option<NaivePca>], components: usize) -> Vec<f64> {
    let distance = |c: &Option<NaivePca>| c.as_ref().map_or(f64::INFINITY, |c| c.squared_distance(row, components));
    clusters.iter().map(distance).collect()
}

/// The nearest cluster of each row; it stays where it is if that is as near.
pub fn assign(rows: &[Vec<f64>], labels: &[usize], clusters: &[Option<NaivePca>], components: usize) -> Vec<usize> {
    let nearest = |(row, &label): (&Vec<f64>, &usize)| {
        let distances = cluster_distances(row, clusters, components);
        let best = (0..distances.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b])).unwrap_or(label);
        if distances[label] <= distances[best] { label } else { best }
    };
    rows.iter().zip(labels).map(nearest).collect()
}

/// Σ |x − x'|², each row in its cluster.
pub fn total_error(rows: &[Vec<f64>], labels: &[usize], clusters: &[Option<NaivePca>], components: usize) -> f64 {
    rows.iter().zip(labels).map(|(row, &label)| cluster_distances(row, clusters, components)[label]).sum()
}
