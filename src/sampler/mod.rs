//! Owen-scrambled Sobol points with named dimensions.
