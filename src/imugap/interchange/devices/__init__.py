"""Models of real devices that are shipped with the library, by name: `imugap models`.

Each file of ``models`` is a model with its card: what it was found on, what is known of it, and what is not. They are
made by the rule ``device_model`` of the workflow from results on public recordings.
"""
