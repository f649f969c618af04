"""Many runs: worlds x variants x seeds, spread over processes of this machine or of a cluster, kept as rows."""
