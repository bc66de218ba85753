"""Alembic runs this: the revisions act on the connection that the store gives."""

from alembic import context

from adibas.sessions.schema import METADATA

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=METADATA,
    render_as_batch=True,
    transaction_per_migration=False,
)
context.run_migrations()
