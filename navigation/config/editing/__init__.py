"""Changes to a configuration, without a text editor.

`form` lists every key with its meaning, limits and present value, from the schema, and reads typed
text as YAML does. `in_text` puts the new values into the configuration's text. The dashboard's
settings use both, in this order.
"""
