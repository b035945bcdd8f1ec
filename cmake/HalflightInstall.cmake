# Install rules come with the package (see docs/architecture.md).
