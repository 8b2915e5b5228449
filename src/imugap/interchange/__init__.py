"""Error models from and to elsewhere: data sheets, performance indices, plug-ins, other filters and simulators.

May import model, effects and what lies below.
"""
