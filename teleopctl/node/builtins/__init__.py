"""Services and topics that every node offers: time source, ``/rosout``, loggers, its types."""
