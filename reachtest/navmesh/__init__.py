"""What several stages need to know of nav-meshes: building one, its islands, its agent."""
